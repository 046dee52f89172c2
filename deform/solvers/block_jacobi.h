// The 3 x 3 blocks on a system's diagonal, inverted: a preconditioner that costs next to nothing.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace keypose {

/// For systems of three coupled coordinates a vertex, whose smooth errors have been removed on a
/// coarser mesh before: what is left is local, and a few dozen conjugate gradients with these
/// blocks remove it for less than it costs to factor a large matrix.
class BlockJacobi {
 public:
  /// @param blocks    V, symmetric, positive semidefinite
  /// @param diagonal  V, added to all three entries of each block's diagonal
  BlockJacobi(const std::vector<Eigen::Matrix3d>& blocks, const Eigen::VectorXd& diagonal);
  /// V x 3 to V x 3; a block that has no inverse gives 0.
  /// Same bits for any thread count.
  Eigen::MatrixXd Apply(const Eigen::MatrixXd& r) const;

 private:
  std::vector<Eigen::Matrix3d> inverse_;
};

}  // namespace keypose
