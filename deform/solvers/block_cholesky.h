// Sparse Cholesky factors for systems that are solved for many right-hand sides at once.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

namespace keypose {

/// Factors symmetric positive definite matrices of one pattern, and solves on rows of right-hand
/// sides.
///
/// A row holds the values of one unknown in all right-hand sides, contiguous in memory. So each
/// entry of the factor is multiplied with whole vectors, and the dense kernels hold twelve
/// right-hand sides by four unknowns in registers. This suits the small supernodes of surface
/// meshes, for which the overhead of a BLAS call is larger than the arithmetic. The sums of a
/// column do not depend on the other columns or on the number of threads. Ordering and supernodes
/// are CHOLMOD's (minimum degree, or METIS when that fills in much). The factorisation is
/// multifrontal (Duff and Reid 1983) and uses the same kernels.
class BlockCholesky {
 public:
  BlockCholesky();
  ~BlockCholesky();
  BlockCholesky(BlockCholesky&&) noexcept;
  BlockCholesky& operator=(BlockCholesky&&) noexcept;

  /// @param lower  N x N, compressed; only the lower triangle is read, and its pattern must hold
  /// all nonzeros
  /// @throws SolverError  too large, or not square
  /// @param dissected  METIS's ordering: ten times the time of the analysis, and a third less in
  /// each solve on surface meshes
  void Analyze(const Eigen::SparseMatrix<double>& lower, bool dissected = false);
  /// A new solver that shares this one's analysis, ready for Factor.
  BlockCholesky SameAnalysis() const;
  /// @param lower  has the pattern that was analysed
  /// @throws SolverError  not positive definite
  void Factor(const Eigen::SparseMatrix<double>& lower);

  /// The unknown of each row in SolveRows, and the row of each unknown.
  const std::vector<int>& unknowns() const;
  const std::vector<int>& rows() const;
  /// The number of columns rounded up to whole vectors: the width of rows in SolveRows.
  static Eigen::Index Padded(Eigen::Index columns) { return (columns + 3) / 4 * 4; }
  /// Solves in place: N rows of `columns` numbers, a multiple of four, rows in the order of
  /// unknowns().
  /// @throws SolverError  the solution is not finite
  void SolveRows(double* x, Eigen::Index columns) const;
  /// The same for rows of four numbers. Here the factor is read from memory for little arithmetic,
  /// so several subtrees of the elimination tree are solved at a time; the sums are in another
  /// order than in SolveRows, but the same for any thread count.
  void SolveFour(double* x) const;
  /// The same for a matrix in the order of the unknowns, N x any number of columns.
  void SolveInPlace(Eigen::MatrixXd& x) const;
  std::size_t factor_entries() const;  ///< stored entries, including zeros in supernodes

 private:
  struct Analysis;
  double* SolveSubtree(bool forward, int subtree, double* x, std::vector<double>& own) const;
  std::shared_ptr<const Analysis> analysis_;
  std::vector<double> factor_, inverse_diagonal_;
};

}  // namespace keypose
