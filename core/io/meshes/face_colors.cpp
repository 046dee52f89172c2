#include "core/io/meshes/face_colors.h"

#include <cmath>
#include <cstddef>

#include "core/io/meshes/some_colors.h"

namespace keypose {

bool TakeFaceColors(const Eigen::MatrixX3d& levels, Mesh* mesh) {
  const Eigen::Index vertices = mesh->points.rows();
  PointsX3 sum = PointsX3::Zero(vertices, 3), first = sum;
  Eigen::VectorXd count = Eigen::VectorXd::Zero(vertices);
  bool blended = false;
  for (Eigen::Index f = 0; f < mesh->faces.rows(); ++f) {
    const Eigen::RowVector3d color = levels.row(f);
    if (!color.allFinite()) continue;
    for (int k = 0; k < 3; ++k) {
      const int v = mesh->faces(f, k);
      if (count[v] == 0) first.row(v) = color;
      blended |= first.row(v) != color;
      sum.row(v) += color;
      count[v] += 1;
    }
  }
  std::vector<std::size_t> colored;
  std::vector<Eigen::Vector3d> colors;
  for (Eigen::Index v = 0; v < vertices; ++v) {
    if (count[v] == 0) continue;
    colored.push_back(static_cast<std::size_t>(v));
    // Just above 1, it would be taken for a level.
    colors.emplace_back((sum.row(v).transpose() / (255 * count[v])).cwiseMin(1));
  }
  if (!colored.empty()) mesh->colors = ColorsOfSome(colored, colors, mesh->faces, vertices);
  return blended;
}

}  // namespace keypose
