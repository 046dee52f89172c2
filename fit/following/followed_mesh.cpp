#include "fit/following/followed_mesh.h"

#include <numeric>

#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "deform/arap/arap_fit.h"

namespace keypose::fit {

FollowedMesh::FollowedMesh(const PointsX3& first, const FacesX3& faces, int most_vertices)
    : faces_(faces), pairs_(FindFacePairs(faces)), unit_(BoundingDiagonal(first) / 2) {
  constexpr double kWorthwhile = 4.0 / 3;
  if (static_cast<double>(first.rows()) > kWorthwhile * most_vertices) {
    std::vector<CoarseLevel> levels = MakeHierarchy(first, faces, {most_vertices});
    if (!levels.empty()) coarse_ = std::move(levels.front());
  }
  if (coarse_) {
    down_ = MakeProlongation(first, *coarse_);
    cell_of_ = coarse_->up;
    fine_of_ = coarse_->fine;
  } else {
    cell_of_.resize(static_cast<std::size_t>(first.rows()));
    std::iota(cell_of_.begin(), cell_of_.end(), 0);
    fine_of_ = cell_of_;
  }
  coarse_first_ = Coarse(first);
  coarse_normals_ = VertexNormals(coarse_first_, coarse_faces());
}

PointsX3 FollowedMesh::Coarse(const PointsX3& points) const {
  if (!coarse_) return points;
  PointsX3 coarse(SizeOf(fine_of_), 3);
  for (int i = 0; i < SizeOf(fine_of_); ++i) coarse.row(i) = points.row(fine_of_[i]);
  return coarse;
}

std::vector<Eigen::Matrix3d> FollowedMesh::TurnsOf(const PointsX3& coarse) const {
  const FacesX3& faces = coarse_faces();
  std::vector<Eigen::Matrix3d> moments(static_cast<std::size_t>(coarse.rows()),
                                       Eigen::Matrix3d::Zero());
  Eigen::VectorXd sizes = Eigen::VectorXd::Zero(coarse.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3);
      const Eigen::Vector3d now = coarse.row(b) - coarse.row(a),
                            then = coarse_first_.row(b) - coarse_first_.row(a);
      const Eigen::Matrix3d moment = now * then.transpose();
      for (const int v : {a, b}) {
        moments[v] += moment;
        sizes[v] += then.squaredNorm();
      }
    }
  // Edges of a flat fan do not tell on which side its normal is.
  const PointsX3 normals = VertexNormals(coarse, faces);
  for (Eigen::Index v = 0; v < coarse.rows(); ++v) {
    const Eigen::Matrix3d m =
        moments[v] + 0.5 * sizes[v] * normals.row(v).transpose() * coarse_normals_.row(v);
    moments[v] = NearestRotation(m);
  }
  return moments;
}

PointsX3 FollowedMesh::Fine(const PointsX3& base, const PointsX3& moved,
                            const std::vector<Eigen::Matrix3d>& maps) const {
  return coarse_ ? Prolong(*down_, base, Coarse(base), moved, maps) : moved;
}

std::vector<Eigen::Matrix3d> FollowedMesh::FineMaps(
    const std::vector<Eigen::Matrix3d>& maps) const {
  std::vector<Eigen::Matrix3d> fine(cell_of_.size());
  for (std::size_t v = 0; v < fine.size(); ++v) fine[v] = maps[cell_of_[v]];
  return fine;
}

}  // namespace keypose::fit
