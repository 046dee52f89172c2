#include "core/cholesky.h"

#include <cblas.h>
#include <cholmod.h>

#include <string>

#include "core/errors.h"

extern "C" void openblas_set_num_threads(int threads);

namespace keypose {

struct SparseCholesky::Impl {
  Impl() {
    // One BLAS thread: sums in the dense kernels must not depend on how many threads share them.
    openblas_set_num_threads(1);
    cholmod_start(&common);
    common.supernodal = CHOLMOD_AUTO;
    common.print = 0;
    common.final_ll = 1;
  }
  ~Impl() {
    if (factor) cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  cholmod_common common{};
  cholmod_factor* factor = nullptr;
  int analyze_calls = 0;
};

namespace {

/// A view of Eigen's arrays as CHOLMOD's symmetric matrix; the caller keeps them alive.
cholmod_sparse ViewOfLower(const Eigen::SparseMatrix<double>& lower) {
  if (!lower.isCompressed() || lower.rows() != lower.cols()) throw SolverError("sparse Cholesky: the matrix must be square and compressed");
  cholmod_sparse view{};
  view.nrow = static_cast<std::size_t>(lower.rows());
  view.ncol = static_cast<std::size_t>(lower.cols());
  view.nzmax = static_cast<std::size_t>(lower.nonZeros());
  view.p = const_cast<int*>(lower.outerIndexPtr());
  view.i = const_cast<int*>(lower.innerIndexPtr());
  view.x = const_cast<double*>(lower.valuePtr());
  view.stype = -1;
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
}

}  // namespace

SparseCholesky::SparseCholesky() : impl_(std::make_unique<Impl>()) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::Analyze(const Eigen::SparseMatrix<double>& lower) {
  cholmod_sparse view = ViewOfLower(lower);
  if (impl_->factor) cholmod_free_factor(&impl_->factor, &impl_->common);
  impl_->factor = cholmod_analyze(&view, &impl_->common);
  ++impl_->analyze_calls;
  if (!impl_->factor) throw SolverError("sparse Cholesky: analysis failed, status " + std::to_string(impl_->common.status));
}

void SparseCholesky::Factor(const Eigen::SparseMatrix<double>& lower) {
  if (!impl_->factor) Analyze(lower);
  cholmod_sparse view = ViewOfLower(lower);
  cholmod_factorize(&view, impl_->factor, &impl_->common);
  if (impl_->common.status == CHOLMOD_NOT_POSDEF || impl_->factor->minor < impl_->factor->n)
    throw SolverError("sparse Cholesky: the system is not positive definite (at unknown " + std::to_string(impl_->factor->minor) +
                      "); a part of the mesh is held by nothing");
  if (impl_->common.status < 0)
    throw SolverError("sparse Cholesky: out of memory or too large, status " + std::to_string(impl_->common.status));
}

Eigen::MatrixXd SparseCholesky::Solve(const Eigen::MatrixXd& b) const {
  if (!impl_->factor) throw SolverError("sparse Cholesky: solve before factor");
  cholmod_dense view{};
  view.nrow = static_cast<std::size_t>(b.rows());
  view.ncol = static_cast<std::size_t>(b.cols());
  view.nzmax = static_cast<std::size_t>(b.size());
  view.d = view.nrow;
  view.x = const_cast<double*>(b.data());
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* x = cholmod_solve(CHOLMOD_A, impl_->factor, &view, &impl_->common);
  if (!x) throw SolverError("sparse Cholesky: solve failed, status " + std::to_string(impl_->common.status));
  Eigen::MatrixXd result = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(x->x), b.rows(), b.cols());
  cholmod_free_dense(&x, &impl_->common);
  if (!result.allFinite()) throw SolverError("sparse Cholesky: the solution is not finite");
  return result;
}

int SparseCholesky::analyze_calls() const { return impl_->analyze_calls; }
long SparseCholesky::factor_nonzeros() const { return static_cast<long>(impl_->common.lnz); }

}  // namespace keypose
