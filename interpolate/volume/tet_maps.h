// The map of each tetrahedron from one key to the next, split into turn and stretch, and the sums
// over tetrahedra that fits need.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <functional>
#include <vector>

#include "core/values/mesh.h"
#include "interpolate/volume/tetrahedralize.h"

namespace keypose::interpolation {

/// Gradients of a tetrahedron's four hat functions, and its volume: J = sum_k x_k
/// gradients.col(k)^T is the map that takes it to corners x.
struct TetShape {
  Eigen::Matrix<double, 3, 4> gradients;  ///< [1/m]
  double volume = 0;                      ///< > 0 [m^3]
};
std::vector<TetShape> TetShapesOf(const PointsX3& points, const TetsX4& tets);
Eigen::Matrix3d MapOf(const TetShape& shape, const PointsX3& to, const TetsX4& tets,
                      Eigen::Index t);

/// The rotation nearest to j, also for a j that mirrors or flattens.
/// Source: scaled Newton iteration, Higham 1986; else by singular values.
Eigen::Matrix3d ClosestRotation(const Eigen::Matrix3d& j);

/// J = rotation * axes * diag(stretch) * axes^T.
struct TetMap {
  Eigen::Matrix3d rotation, axes;
  /// decreasing; the last is negative for an inverted tetrahedron
  Eigen::Vector3d stretch;
  bool inverted = false;  ///< inverted or flat: its stretch has no power
};
std::vector<TetMap> TetMapsOf(const std::vector<TetShape>& shapes, const PointsX3& to,
                              const TetsX4& tets);

/// Sums the terms of each tetrahedron at its corners, in an order that does not depend on the
/// thread count.
class CornerSums {
 public:
  CornerSums(Eigen::Index point_count, const TetsX4& tets);
  /// @param term  fills the four corners' vectors (columns) for tetrahedron t
  PointsX3 Sum(
      const std::function<void(std::int64_t t, Eigen::Matrix<double, 3, 4>& corners)>& term) const;

 private:
  std::vector<int> first_, corners_;  // of each point; a corner is 4 t + k
};

/// Lower triangle of sum over tetrahedra of gradients^T * weight(t) * gradients; SPD weights give
/// the Laplacian of a weighted Dirichlet energy.
Eigen::SparseMatrix<double> LaplacianOf(
    Eigen::Index point_count, const TetsX4& tets, const std::vector<TetShape>& shapes,
    const std::function<Eigen::Matrix3d(std::int64_t t)>& weight);

}  // namespace keypose::interpolation
