// A cheap preconditioner: the inverses of the 3 x 3 blocks on a system's diagonal.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace keypose {

/// For systems with three coupled coordinates for each vertex whose smooth errors a coarser mesh
/// has removed already. The remaining errors are local. A few dozen conjugate gradient steps with
/// these blocks remove them at less cost than factoring a large matrix.
class BlockJacobi {
 public:
  /// @param blocks    V, symmetric, positive semidefinite
  /// @param diagonal  V, added to all three entries of each block's diagonal
  BlockJacobi(const std::vector<Eigen::Matrix3d>& blocks, const Eigen::VectorXd& diagonal);
  /// Maps V x 3 to V x 3. A block without an inverse gives 0.
  /// Same bits for any thread count.
  Eigen::MatrixXd Apply(const Eigen::MatrixXd& r) const;

 private:
  std::vector<Eigen::Matrix3d> inverse_;
};

}  // namespace keypose
