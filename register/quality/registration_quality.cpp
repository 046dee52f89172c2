#include "register/quality/registration_quality.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/self_intersections.h"
#include "core/values/tuned.h"
#include "register/quality/closest_points.h"
#include "register/quality/flipped_faces.h"

namespace keypose::registration {

namespace {

constexpr int kQualitySamples = 6000;
constexpr double kCovered = 0.01;    // of the diagonal
constexpr double kWorstRatio = 1e6;  // for a face that has collapsed to a line

// Chosen on the seven registration pairs (docs/algorithms/register.md). Sensitivity:
// docs/results/sensitivity.md.
struct FlippedFaceTuning {
  // of the diagonal: the accuracy of a good registration. In a crease, a wall that is farther by
  // less than this may be the right one for a face.
  KEYPOSE_TUNED(double, kFlipSlack, 0.002);
};

using FootList = std::vector<RayScene::Foot>;

void CountFlipped(const PointsX3& registered, const FacesX3& faces, const Mesh& target,
                  RegistrationQuality& q) {
  const TargetFaces sides(target.points, target.faces);
  const auto count = [&](double slack) {
    const std::vector<char> flipped = sides.Opposed(registered, faces, slack);
    return static_cast<int>(std::count(flipped.begin(), flipped.end(), 1));
  };
  q.flipped = count(0);
  q.flipped_clearly = count(FlippedFaceTuning::kFlipSlack * BoundingDiagonal(target.points));
}

double UnitRandom(std::uint64_t n) {  // SplitMix64 of Steele et al., 2014
  n += 0x9e3779b97f4a7c15ULL;
  n = (n ^ (n >> 30)) * 0xbf58476d1ce4e5b9ULL;
  n = (n ^ (n >> 27)) * 0x94d049bb133111ebULL;
  return static_cast<double>((n ^ (n >> 31)) >> 11) * 0x1.0p-53;
}

/// One sample in each of kQualitySamples parts of equal area, face after face. This has less
/// variance than independent samples. Consecutive samples are also near each other, so that a
/// search can start from the result of the one before.
SurfaceSamples Stratified(const PointsX3& points, const FacesX3& faces, std::uint64_t seed) {
  const Eigen::VectorXd areas = FaceAreas(points, faces);
  const double total = areas.sum();
  SurfaceSamples samples;
  if (!(total > 0)) return samples;
  samples.points.resize(kQualitySamples, 3);
  samples.faces.resize(kQualitySamples);
  Eigen::Index f = 0;
  double before = 0;
  for (int i = 0; i < kQualitySamples; ++i) {
    const std::uint64_t n = (seed * kQualitySamples + static_cast<std::uint64_t>(i)) * 3;
    const double place = total * (i + UnitRandom(n)) / kQualitySamples;
    while (f + 1 < faces.rows() && before + areas[f] <= place) before += areas[f++];
    const double r = std::sqrt(UnitRandom(n + 1)), s = UnitRandom(n + 2);
    samples.points.row(i) = (1 - r) * points.row(faces(f, 0)) +
                            r * (1 - s) * points.row(faces(f, 1)) + r * s * points.row(faces(f, 2));
    samples.faces[i] = static_cast<int>(f);
  }
  return samples;
}

/// Mean distance and mean squared distance of samples, and the largest of samples and vertices.
struct Distances {
  double mean = 0, mean_square = 0, largest = 0;
  Distances(const FootList& samples, const FootList& vertices) {
    for (const RayScene::Foot& foot : samples) {
      mean += std::sqrt(foot.squared_distance) / static_cast<double>(samples.size());
      mean_square += foot.squared_distance / static_cast<double>(samples.size());
      largest = std::max(largest, std::sqrt(foot.squared_distance));
    }
    for (const RayScene::Foot& foot : vertices)
      largest = std::max(largest, std::sqrt(foot.squared_distance));
  }
};

/// Squares of the two singular values of the map between two triangles.
/// @return false for a source triangle without area
bool SquaredStretches(const PointsX3& from, const PointsX3& to, const Eigen::Vector3i& f,
                      double& small, double& large) {
  const Eigen::Vector3d u = from.row(f[1]) - from.row(f[0]), v = from.row(f[2]) - from.row(f[0]);
  const Eigen::Vector3d p = to.row(f[1]) - to.row(f[0]), q = to.row(f[2]) - to.row(f[0]);
  // In the plane of the source triangle, u = (ux, 0) and v = (vx, vy). The columns of the map are
  // p / ux and (q - vx p / ux) / vy.
  const double ux = u.norm();
  const double vx = ux > 0 ? u.dot(v) / ux : 0, vy = ux > 0 ? u.cross(v).norm() / ux : 0;
  if (!(ux > 0) || !(vy > 1e-12 * v.norm())) return false;
  const Eigen::Vector3d x = p / ux, y = (q - vx * x) / vy;
  const double a = x.squaredNorm(), b = x.dot(y), c = y.squaredNorm();
  large = (a + c) / 2 + std::hypot((a - c) / 2, b);
  // The product of both singular values is the determinant. A difference would lose precision.
  small = large > 0 ? std::min(large, x.cross(y).squaredNorm() / large) : 0;
  return true;
}

double WeightedQuantile(const std::vector<std::pair<double, double>>& sorted, double total,
                        double share) {
  double before = 0;
  for (const auto& [value, weight] : sorted) {
    before += weight;
    if (before >= share * total) return value;
  }
  return sorted.back().first;
}

void RequireSamePoints(const Mesh& source, const PointsX3& registered) {
  RequireOnePerVertex(registered.rows(), source.points.rows(), "register: the registered mesh has",
                      "vertices", "the source", "");
}

}  // namespace

Stretch MeasureStretch(const Mesh& source, const PointsX3& registered) {
  RequireSamePoints(source, registered);
  const Eigen::VectorXd areas = FaceAreas(source.points, source.faces);
  const double ratio = SurfaceArea(registered, source.faces) / areas.sum();
  const double scale = std::isfinite(ratio) && ratio > 0 ? std::sqrt(ratio) : 1;
  std::vector<std::pair<double, double>> values;
  values.reserve(2 * static_cast<std::size_t>(areas.size()));
  Stretch stretch;
  double total = 0;
  for (Eigen::Index f = 0; f < areas.size(); ++f) {
    double small = 0, large = 0;
    if (!SquaredStretches(source.points, registered, source.faces.row(f), small, large)) continue;
    values.emplace_back(std::sqrt(small) / scale, areas[f]);
    values.emplace_back(std::sqrt(large) / scale, areas[f]);
    total += 2 * areas[f];
    if (large > 0)
      stretch.worst_ratio = std::max(
          stretch.worst_ratio, std::min(kWorstRatio, std::sqrt(large / std::max(small, 1e-300))));
  }
  if (values.empty()) return stretch;
  std::sort(values.begin(), values.end());
  stretch.smallest = values.front().first;
  stretch.largest = values.back().first;
  stretch.low = WeightedQuantile(values, total, 0.01);
  stretch.median = WeightedQuantile(values, total, 0.5);
  stretch.high = WeightedQuantile(values, total, 0.99);
  return stretch;
}

ResultSurfaces MakeResultSurfaces(const Mesh& source, const PointsX3& registered,
                                  const Mesh& target) {
  RequireSamePoints(source, registered);
  Mesh moved;
  moved.points = registered;
  moved.faces = source.faces;
  RequireUsable(moved, "register: registered");
  RequireUsable(target, "register: target");
  return {RayScene(target.points, target.faces), RayScene(registered, source.faces)};
}

RegistrationQuality MeasureRegistration(const Mesh& source, const PointsX3& registered,
                                        const Mesh& target) {
  return MeasureRegistration(source, registered, target,
                             MakeResultSurfaces(source, registered, target));
}

RegistrationQuality MeasureRegistration(const Mesh& source, const PointsX3& registered,
                                        const Mesh& target, const ResultSurfaces& surfaces) {
  RegistrationQuality q;
  const double diagonal =
      std::max(BoundingDiagonal(target.points), std::numeric_limits<double>::min());
  const SurfaceSamples ours = Stratified(registered, source.faces, 1),
                       theirs = Stratified(target.points, target.faces, 2);
  const FootList vertices_to = ClosestPoints(surfaces.target, registered),
                 vertices_from = ClosestPoints(surfaces.registered, target.points);
  const FootList to =
      ours.faces.empty() ? vertices_to : ClosestPoints(surfaces.target, ours.points);
  const FootList from =
      theirs.faces.empty() ? vertices_from : ClosestPoints(surfaces.registered, theirs.points);
  const Distances there(to, vertices_to), back(from, vertices_from);
  q.hausdorff_to_target = there.largest / diagonal;
  q.hausdorff_from_target = back.largest / diagonal;
  q.surface_mean = (there.mean + back.mean) / 2 / diagonal;
  q.surface_rms = std::sqrt((there.mean_square + back.mean_square) / 2) / diagonal;
  const PointsX3 our_normals = FaceNormals(registered, source.faces),
                 their_normals = FaceNormals(target.points, target.faces);
  int covered = 0;
  for (std::size_t i = 0; i < theirs.faces.size(); ++i)
    covered += std::sqrt(from[i].squared_distance) <= kCovered * diagonal &&
               our_normals.row(from[i].face).dot(their_normals.row(theirs.faces[i])) > 0;
  q.coverage = theirs.faces.empty() ? 0 : covered / static_cast<double>(theirs.faces.size());
  CountFlipped(registered, source.faces, target, q);
  const Eigen::VectorXd before = FaceAreas(source.points, source.faces),
                        after = FaceAreas(registered, source.faces);
  q.degenerate = static_cast<int>((after.array() < 0.01 * before.array()).count());
  q.self_intersections =
      FindSelfIntersections(registered, source.faces, TouchingFaces::kLeftOut).pairs;
  q.self_intersections_gained =
      q.self_intersections -
      FindSelfIntersections(source.points, source.faces, TouchingFaces::kLeftOut).pairs;
  q.stretch = MeasureStretch(source, registered);
  return q;
}

}  // namespace keypose::registration
