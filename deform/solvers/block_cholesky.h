// Sparse Cholesky factors for systems that are solved for many right-hand sides at once.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

namespace keypose {

/// Factors of symmetric positive definite matrices of one pattern, and solves on rows of right-hand
/// sides.
///
/// A row of right-hand sides, one number a system, lies together in memory, so that each entry of
/// the factor meets a few whole vectors of numbers, and what the dense kernels hold in registers is
/// twelve systems by four unknowns. That suits the small supernodes of surfaces, which a BLAS call
/// each would cost more than their arithmetic. Every column goes through the same sums whatever
/// columns lie beside it, so its bits depend neither on the others nor on the number of threads.
/// Order and supernodes are CHOLMOD's (minimum degree; METIS where that fills in much); the
/// factorisation is multifrontal (Duff and Reid 1983), on the same kernels.
class BlockCholesky {
 public:
  BlockCholesky();
  ~BlockCholesky();
  BlockCholesky(BlockCholesky&&) noexcept;
  BlockCholesky& operator=(BlockCholesky&&) noexcept;

  /// @param lower  N x N, compressed; only its lower triangle, which must hold all that is not zero
  /// @throws SolverError  too large, or not square
  void Analyze(const Eigen::SparseMatrix<double>& lower);
  /// Another solver with this one's analysis, ready for Factor.
  BlockCholesky SameAnalysis() const;
  /// @param lower  of the pattern that was analysed
  /// @throws SolverError  not positive definite
  void Factor(const Eigen::SparseMatrix<double>& lower);

  /// Unknown of each row, in the order that SolveRows wants them; and the row of each unknown.
  const std::vector<int>& unknowns() const;
  const std::vector<int>& rows() const;
  /// Columns rounded up to whole vectors: the width of rows in SolveRows.
  static Eigen::Index Padded(Eigen::Index columns) { return (columns + 3) / 4 * 4; }
  /// Solves in place: N rows of `columns` numbers, a multiple of four, rows in the order of
  /// unknowns().
  /// @throws SolverError  the solution is not finite
  void SolveRows(double* x, Eigen::Index columns) const;
  /// The same for a matrix in the order of the unknowns, N x any number of columns.
  void SolveInPlace(Eigen::MatrixXd& x) const;
  std::size_t factor_entries() const;  ///< stored, with the zeros in supernodes

 private:
  struct Analysis;
  std::shared_ptr<const Analysis> analysis_;
  std::vector<double> factor_, inverse_diagonal_;
};

}  // namespace keypose
