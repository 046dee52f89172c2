#include "deform/solvers/block_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"

namespace keypose::block_cholesky_test {

/// The Laplacian of a grid of side x side, plus `ground` on its diagonal. Wide enough for
/// supernodes of all shapes.
Eigen::SparseMatrix<double> Grid(int side, double ground) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto join = [&](int i, int j) {
    entries.emplace_back(i, i, 1);
    entries.emplace_back(j, j, 1);
    entries.emplace_back(std::max(i, j), std::min(i, j), -1);
  };
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const int i = y * side + x;
      entries.emplace_back(i, i, ground);
      if (x + 1 < side) join(i, i + 1);
      if (y + 1 < side) join(i, i + side);
      if (x + 1 < side && y + 1 < side) join(i, i + side + 1);
    }
  Eigen::SparseMatrix<double> lower(side * side, side * side);
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

TEST(BlockCholesky, SolvesLikeADenseSolverForAnyNumberOfColumns) {
  for (const int side : {1, 2, 7, 24}) {
    const auto lower = Grid(side, 0.3);
    const Eigen::MatrixXd full = Eigen::MatrixXd(lower).selfadjointView<Eigen::Lower>();
    BlockCholesky solver;
    solver.Analyze(lower);
    solver.Factor(lower);
    for (const int columns : {1, 4, 7, 12, 31}) {
      const Eigen::MatrixXd b = Eigen::MatrixXd::Random(side * side, columns);
      Eigen::MatrixXd x = b;
      solver.SolveInPlace(x);
      EXPECT_LT((full * x - b).norm(), 1e-12 * b.norm()) << side << ", " << columns;
    }
  }
}

TEST(BlockCholesky, OneAnalysisServesOtherValues) {
  BlockCholesky first;
  first.Analyze(Grid(12, 1));
  BlockCholesky second = first.SameAnalysis();
  first.Factor(Grid(12, 1));
  second.Factor(Grid(12, 9));
  second.Factor(Grid(12, 4));
  const Eigen::MatrixXd full = Eigen::MatrixXd(Grid(12, 4)).selfadjointView<Eigen::Lower>(),
                        b = Eigen::MatrixXd::Random(144, 2);
  Eigen::MatrixXd x = b;
  second.SolveInPlace(x);
  EXPECT_LT((full * x - b).norm(), 1e-12 * b.norm());
}

TEST(BlockCholesky, AColumnHasItsBitsWhateverLiesBesideItAndOnAnyThreads) {
  BlockCholesky solver;
  solver.Analyze(Grid(20, 0.1));
  solver.Factor(Grid(20, 0.1));
  const Eigen::MatrixXd b = Eigen::MatrixXd::Random(400, 29);
  Eigen::MatrixXd together = b, alone = b.col(17), on_three = b;
  SetThreadCount(1);
  solver.SolveInPlace(together);
  solver.SolveInPlace(alone);
  SetThreadCount(3);
  solver.SolveInPlace(on_three);
  SetThreadCount(0);
  EXPECT_EQ(together.col(17), alone);
  EXPECT_EQ(together, on_three);
}

TEST(BlockCholesky, SubtreesSideBySideGiveTheSameSolutionAndTheSameBitsOnAnyThreads) {
  for (const bool dissected : {false, true})
    for (const int side : {1, 3, 40}) {
      const int n = side * side;
      BlockCholesky solver;
      solver.Analyze(Grid(side, 0.2), dissected);
      solver.Factor(Grid(side, 0.2));
      const Eigen::MatrixXd b = Eigen::MatrixXd::Random(n, 4);
      Eigen::MatrixXd expected = b;
      solver.SolveInPlace(expected);
      const auto solved = [&](int threads) {
        Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> rows(n, 4), x(n, 4);
        for (int i = 0; i < n; ++i) rows.row(solver.rows()[i]) = b.row(i);
        SetThreadCount(threads);
        solver.SolveFour(rows.data());
        SetThreadCount(0);
        for (int i = 0; i < n; ++i) x.row(i) = rows.row(solver.rows()[i]);
        return x;
      };
      EXPECT_LT((solved(1) - expected).norm(), 1e-13 * expected.norm()) << side;
      EXPECT_EQ(solved(1), solved(3));
    }
}

TEST(BlockCholesky, WhatCannotBeSolvedThrows) {
  BlockCholesky solver;
  Eigen::MatrixXd b = Eigen::MatrixXd::Ones(81, 1);
  EXPECT_THROW(solver.SolveInPlace(b), SolverError);
  std::vector<double> four(4 * 81, std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW(solver.SolveFour(four.data()), SolverError);
  solver.Analyze(Grid(9, 1));
  EXPECT_THROW(solver.Factor(Grid(9, -1)), SolverError);
  solver.Factor(Grid(9, 1));
  EXPECT_THROW(solver.SolveFour(four.data()), SolverError);
  b(40, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(solver.SolveInPlace(b), SolverError);
}

}  // namespace keypose::block_cholesky_test
