#include "deform/solvers/block_jacobi.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <vector>

namespace keypose::block_jacobi_test {

TEST(BlockJacobi, InvertsEachBlockWithItsDiagonal) {
  Eigen::Matrix3d block;
  block << 4, 1, 0, 1, 3, 0.5, 0, 0.5, 2;
  const BlockJacobi jacobi({block, 2 * block}, Eigen::Vector2d(0, 0.5));
  Eigen::MatrixXd r(2, 3);
  r << 1, 2, 3, -1, 0, 4;
  const Eigen::MatrixXd x = jacobi.Apply(r);
  EXPECT_LT((block * x.row(0).transpose() - r.row(0).transpose()).norm(), 1e-12);
  const Eigen::Matrix3d second = 2 * block + 0.5 * Eigen::Matrix3d::Identity();
  EXPECT_LT((second * x.row(1).transpose() - r.row(1).transpose()).norm(), 1e-12);
}

TEST(BlockJacobi, ABlockWithoutAnInverseGivesZero) {
  const BlockJacobi jacobi({Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()},
                           Eigen::Vector2d(0, 2));
  const Eigen::MatrixXd x = jacobi.Apply(Eigen::MatrixXd::Ones(2, 3));
  EXPECT_EQ(x.row(0).norm(), 0);
  EXPECT_LT((x.row(1) - Eigen::RowVector3d::Constant(0.5)).norm(), 1e-14);
}

}  // namespace keypose::block_jacobi_test
