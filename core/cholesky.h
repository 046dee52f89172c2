// Sparse Cholesky factorisation of symmetric positive definite matrices (by CHOLMOD).
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>

namespace keypose {

/// Analyses once, factors many times, solves many right-hand sides together.
class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  /// @param lower  N x N; only its lower triangle is read. The pattern must hold for later calls of
  /// Factor.
  void Analyze(const Eigen::SparseMatrix<double>& lower);
  /// @throws SolverError  not positive definite
  void Factor(const Eigen::SparseMatrix<double>& lower);
  /// @param b  N x R @return N x R
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& b) const;
  /// Replaces b, N x R, by the solution. Columns are solved in blocks on all threads; same bits for
  /// any thread count.
  void SolveInPlace(Eigen::MatrixXd& b) const;
  /// For systems that are solved many times after each factorisation: keeps to column-wise factors
  /// for longer (some thousand unknowns), which solve few right-hand sides half again as fast. Call
  /// it before Analyze.
  void PreferSolves();
  /// A solver with this one's analysis, ready for Factor with other values of the same pattern.
  /// Call it between Analyze and Factor.
  SparseCholesky SameAnalysis() const;
  int analyze_calls() const;  ///< how often the pattern was analysed
  long factor_nonzeros() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose
