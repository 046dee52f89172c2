#include "register/quality/flipped_faces.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"

namespace keypose::registration {

namespace {

constexpr std::int64_t kFlippedGrain = 256;

PointsX3 FaceCentres(const PointsX3& points, const FacesX3& faces) {
  PointsX3 centres(faces.rows(), 3);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    centres.row(f) =
        (points.row(faces(f, 0)) + points.row(faces(f, 1)) + points.row(faces(f, 2))) / 3;
  return centres;
}

}  // namespace

TargetFaces::TargetFaces(const PointsX3& points, const FacesX3& faces)
    : centres(FaceCentres(points, faces)), normals(FaceNormals(points, faces)), tree(centres) {}

std::vector<char> TargetFaces::Opposed(const PointsX3& points, const FacesX3& faces,
                                       double slack) const {
  const PointsX3 at = FaceCentres(points, faces), direction = FaceNormals(points, faces);
  const auto away_from = [&](std::int64_t f, const KdTree::Neighbor& near) {
    return direction.row(f).dot(normals.row(near.index)) < 0;
  };
  const auto opposed_by_all = [&](std::int64_t f) {
    const Eigen::Vector3d centre = at.row(f).transpose();
    const KdTree::Neighbor nearest = tree.Nearest(centre);
    if (!away_from(f, nearest)) return false;
    if (slack == 0) return true;
    const double reach = std::sqrt(nearest.squared_distance) + slack;
    const std::vector<KdTree::Neighbor> near = tree.Within(centre, reach);
    return std::all_of(near.begin(), near.end(),
                       [&](const KdTree::Neighbor& one) { return away_from(f, one); });
  };
  std::vector<char> opposed(faces.rows());
  ParallelBlocks(faces.rows(), kFlippedGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f) opposed[f] = opposed_by_all(f);
  });
  return opposed;
}

}  // namespace keypose::registration
