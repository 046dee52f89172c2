#include "core/numbers/cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "core/values/errors.h"

namespace keypose::cholesky_test {

/// The matrix of a chain of springs, with `ground` added at its first node.
Eigen::SparseMatrix<double> Chain(int n, double ground) {
  std::vector<Eigen::Triplet<double>> entries{{0, 0, ground}};
  for (int i = 0; i + 1 < n; ++i) {
    entries.emplace_back(i, i, 1);
    entries.emplace_back(i + 1, i + 1, 1);
    entries.emplace_back(i + 1, i, -1);
  }
  Eigen::SparseMatrix<double> lower(n, n);
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

TEST(SparseCholesky, SolvesLikeADenseSolver) {
  const auto lower = Chain(40, 0.5);
  const Eigen::MatrixXd full = Eigen::MatrixXd(lower).selfadjointView<Eigen::Lower>();
  const Eigen::MatrixXd b = Eigen::MatrixXd::Random(40, 3);
  SparseCholesky solver;
  solver.Factor(lower);
  EXPECT_LT((solver.Solve(b) - full.ldlt().solve(b)).norm(), 1e-10);
}

TEST(SparseCholesky, RefactorsWithoutAnalysingAgain) {
  SparseCholesky solver;
  solver.Analyze(Chain(30, 1));
  solver.Factor(Chain(30, 1));
  solver.Factor(Chain(30, 9));
  EXPECT_EQ(solver.analyze_calls(), 1);
}

TEST(SparseCholesky, FloatingSystemThrowsSolverError) {
  SparseCholesky solver;
  EXPECT_THROW(solver.Factor(Chain(10, -1)), SolverError);
}

}  // namespace keypose::cholesky_test
