#include "deform/solvers/block_jacobi.h"

#include <iterator>

#include <Eigen/LU>

#include "core/numbers/parallel.h"

namespace keypose {

namespace {
constexpr std::int64_t kJacobiGrain = 4096;
}

BlockJacobi::BlockJacobi(const std::vector<Eigen::Matrix3d>& blocks,
                         const Eigen::VectorXd& diagonal)
    : inverse_(blocks.size()) {
  ParallelBlocks(std::ssize(blocks), kJacobiGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      Eigen::Matrix3d block = blocks[i];
      block.diagonal().array() += diagonal[i];
      inverse_[i] = block.determinant() > 0 ? Eigen::Matrix3d(block.inverse())
                                            : Eigen::Matrix3d(Eigen::Matrix3d::Zero());
    }
  });
}

Eigen::MatrixXd BlockJacobi::Apply(const Eigen::MatrixXd& r) const {
  Eigen::MatrixXd z(r.rows(), 3);
  ParallelBlocks(r.rows(), kJacobiGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) z.row(i) = r.row(i) * inverse_[i];
  });
  return z;
}

}  // namespace keypose
