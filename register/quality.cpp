#include "register/quality.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/geometry.h"
#include "core/kd_tree.h"
#include "core/parallel.h"
#include "register/correspondence.h"

namespace keypose::registration {

namespace {

constexpr int kSamples = 20000;

PointsX3 FaceCentres(const PointsX3& points, const FacesX3& faces) {
  PointsX3 centres(faces.rows(), 3);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    centres.row(f) = (points.row(faces(f, 0)) + points.row(faces(f, 1)) + points.row(faces(f, 2))) / 3;
  return centres;
}

int CountFlipped(const Mesh& source, const PointsX3& registered, const Mesh& target) {
  const KdTree tree(FaceCentres(target.points, target.faces));
  const PointsX3 centres = FaceCentres(registered, source.faces);
  const PointsX3 ours = FaceNormals(registered, source.faces), theirs = FaceNormals(target.points, target.faces);
  std::vector<char> flipped(centres.rows());
  ParallelFor(
      centres.rows(), [&](std::int64_t f) { flipped[f] = ours.row(f).dot(theirs.row(tree.Nearest(centres.row(f)).index)) < 0; }, 256);
  return static_cast<int>(std::count(flipped.begin(), flipped.end(), 1));
}

PointsX3 SamplesAndVertices(const PointsX3& points, const FacesX3& faces, std::uint64_t seed) {
  if (!(SurfaceArea(points, faces) > 0)) return points;
  const PointsX3 samples = SampleSurface(points, faces, kSamples, seed).points;
  PointsX3 all(samples.rows() + points.rows(), 3);
  all << samples, points;
  return all;
}

}  // namespace

RegistrationQuality MeasureRegistration(const Mesh& source, const PointsX3& registered, const Mesh& target) {
  RegistrationQuality q;
  const double diagonal = BoundingDiagonal(target.points);
  const PointsX3 a = SamplesAndVertices(registered, source.faces, 1), b = SamplesAndVertices(target.points, target.faces, 2);
  const Eigen::VectorXd ab = TargetSurface(target.points, target.faces).Distances(a) / diagonal;
  const Eigen::VectorXd ba = TargetSurface(registered, source.faces).Distances(b) / diagonal;
  q.hausdorff_to_target = ab.maxCoeff();
  q.hausdorff_from_target = ba.maxCoeff();
  // Means over area samples only; the vertices, which come last, would weigh finely meshed parts more.
  const auto sampled_a = ab.head(std::min<Eigen::Index>(kSamples, ab.size())),
             sampled_b = ba.head(std::min<Eigen::Index>(kSamples, ba.size()));
  q.surface_mean = (sampled_a.mean() + sampled_b.mean()) / 2;
  q.surface_rms = std::sqrt(
      (sampled_a.squaredNorm() / static_cast<double>(sampled_a.size()) + sampled_b.squaredNorm() / static_cast<double>(sampled_b.size())) /
      2);
  q.flipped = CountFlipped(source, registered, target);
  const Eigen::VectorXd before = FaceAreas(source.points, source.faces), after = FaceAreas(registered, source.faces);
  q.degenerate = static_cast<int>((after.array() < 0.01 * before.array()).count());
  return q;
}

}  // namespace keypose::registration
