// Sparse Cholesky factorisation of symmetric positive definite matrices (by CHOLMOD).
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>

namespace keypose {

/// Analyses a sparsity pattern once, factors matrices of that pattern, and solves for many
/// right-hand sides at once.
class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  /// @param lower  N x N; only its lower triangle is read. Later calls of Factor must have the same
  /// pattern.
  void Analyze(const Eigen::SparseMatrix<double>& lower);
  /// @throws SolverError  not positive definite
  void Factor(const Eigen::SparseMatrix<double>& lower);
  /// @param b  N x R @return N x R
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& b) const;
  /// Replaces b, N x R, by the solution. Columns are solved in blocks on all threads.
  /// Same bits for any thread count.
  void SolveInPlace(Eigen::MatrixXd& b) const;
  /// A new solver that shares this one's analysis, ready for Factor with other values of the same
  /// pattern. Call it between Analyze and Factor.
  SparseCholesky SameAnalysis() const;
  int analyze_calls() const;  ///< how often the pattern was analysed
  long factor_nonzeros() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose
