#include "register/quality/flipped_faces.h"

#include "core/geometry.h"
#include "core/parallel.h"

namespace keypose::registration {

namespace {
constexpr std::int64_t kFlippedGrain = 256;
}

PointsX3 FaceCentres(const PointsX3& points, const FacesX3& faces) {
  PointsX3 centres(faces.rows(), 3);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    centres.row(f) =
        (points.row(faces(f, 0)) + points.row(faces(f, 1)) + points.row(faces(f, 2))) / 3;
  return centres;
}

TargetFaces::TargetFaces(const PointsX3& points, const FacesX3& faces)
    : centres(FaceCentres(points, faces)), normals(FaceNormals(points, faces)), tree(centres) {}

std::vector<char> TargetFaces::Opposed(const PointsX3& points, const FacesX3& faces) const {
  const PointsX3 at = FaceCentres(points, faces), direction = FaceNormals(points, faces);
  std::vector<char> opposed(faces.rows());
  ParallelBlocks(faces.rows(), kFlippedGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f)
      opposed[f] = direction.row(f).dot(normals.row(tree.Nearest(at.row(f).transpose()).index)) < 0;
  });
  return opposed;
}

}  // namespace keypose::registration
