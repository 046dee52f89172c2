// A CHOLMOD factor of one fixed pattern with a custom ordering. Values are replaced in place, and
// solves reuse their workspace.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "deform/solvers/sparse_pattern.h"

namespace keypose {

class CholmodFactor {
 public:
  /// Orders the graph of V nodes by nested dissection, expands the ordering to 4V unknowns, and
  /// analyses once.
  /// @throws SolverError  the analysis failed
  explicit CholmodFactor(const SparsePattern& pattern);
  ~CholmodFactor();

  /// @param values  one per slot of the pattern
  /// @throws SolverError  not positive definite, or out of memory
  void Factor(const std::vector<double>& values);
  bool factored() const;
  /// b is 4V x 3.
  /// @throws SolverError
  void Solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x);
  long nonzeros() const;
  int analyses() const;
  int factorisations() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose
