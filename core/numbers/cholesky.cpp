#include "core/numbers/cholesky.h"

#include <cblas.h>
#include <cholmod.h>
#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/numbers/blas_threads.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"

namespace keypose {

namespace {

/// While this object exists, OpenMP regions of this thread run on this thread alone. CHOLMOD starts
/// four threads in every supernode, even if the environment sets another number, and they use
/// processor time while they wait. On a busy machine this costs several times as much as the
/// factorisation.
class OneOpenMpThread {
 public:
  OneOpenMpThread() {
    if (!Set()) return;
    levels_ = Get()();
    Set()(0);
  }
  ~OneOpenMpThread() {
    if (Set()) Set()(levels_);
  }

 private:
  using SetLevels = void (*)(int);
  using GetLevels = int (*)();
  // Found at run time: the library is only loaded when CHOLMOD was built with OpenMP.
  static SetLevels Set() {
    static const auto set =
        reinterpret_cast<SetLevels>(dlsym(RTLD_DEFAULT, "omp_set_max_active_levels"));
    return Get() ? set : nullptr;
  }
  static GetLevels Get() {
    static const auto get =
        reinterpret_cast<GetLevels>(dlsym(RTLD_DEFAULT, "omp_get_max_active_levels"));
    return get;
  }
  int levels_ = 1;
};

}  // namespace

struct SparseCholesky::Impl {
  Impl() {
    UseOneBlasThread();
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

constexpr Eigen::Index kNarrow = 8, kWide = 48;  // columns solved together

/// The CHOLMOD state for a solve. Threads must not share it.
struct SolveSpace {
  SolveSpace() {
    cholmod_start(&common);
    common.print = 0;
  }
  ~SolveSpace() {
    cholmod_free_dense(&y, &common);
    cholmod_free_dense(&e, &common);
    cholmod_finish(&common);
  }
  cholmod_common common{};
  cholmod_dense *y = nullptr, *e = nullptr;
};

cholmod_dense ViewOf(double* data, Eigen::Index rows, Eigen::Index cols) {
  cholmod_dense view{};
  view.nrow = static_cast<std::size_t>(rows);
  view.ncol = static_cast<std::size_t>(cols);
  view.nzmax = static_cast<std::size_t>(rows * cols);
  view.d = view.nrow;
  view.x = data;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  return view;
}

}  // namespace

namespace {

/// A view of Eigen's arrays as CHOLMOD's symmetric matrix; the caller keeps them alive.
cholmod_sparse ViewOfLower(const Eigen::SparseMatrix<double>& lower) {
  if (!lower.isCompressed() || lower.rows() != lower.cols())
    throw SolverError("sparse Cholesky: the matrix must be square and compressed");
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
  if (!impl_->factor)
    throw SolverError("sparse Cholesky: analysis failed, status " +
                      std::to_string(impl_->common.status));
}

void SparseCholesky::Factor(const Eigen::SparseMatrix<double>& lower) {
  if (!impl_->factor) Analyze(lower);
  cholmod_sparse view = ViewOfLower(lower);
  const OneOpenMpThread one_thread;
  cholmod_factorize(&view, impl_->factor, &impl_->common);
  if (impl_->common.status == CHOLMOD_NOT_POSDEF || impl_->factor->minor < impl_->factor->n)
    throw SolverError("sparse Cholesky: the system is not positive definite (at unknown " +
                      std::to_string(impl_->factor->minor) +
                      "); a part of the mesh has no constraint");
  if (impl_->common.status < 0)
    throw SolverError("sparse Cholesky: out of memory or too large, status " +
                      std::to_string(impl_->common.status));
}

Eigen::MatrixXd SparseCholesky::Solve(const Eigen::MatrixXd& b) const {
  if (!impl_->factor) throw SolverError("sparse Cholesky: solve before factor");
  cholmod_dense view = ViewOf(const_cast<double*>(b.data()), b.rows(), b.cols());
  const OneOpenMpThread one_thread;
  cholmod_dense* x = cholmod_solve(CHOLMOD_A, impl_->factor, &view, &impl_->common);
  if (!x)
    throw SolverError("sparse Cholesky: solve failed, status " +
                      std::to_string(impl_->common.status));
  Eigen::MatrixXd result =
      Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(x->x), b.rows(), b.cols());
  cholmod_free_dense(&x, &impl_->common);
  if (!result.allFinite()) throw SolverError("sparse Cholesky: the solution is not finite");
  return result;
}

void SparseCholesky::SolveInPlace(Eigen::MatrixXd& b) const {
  if (!impl_->factor) throw SolverError("sparse Cholesky: solve before factor");
  // Blocks do not depend on the number of threads, so neither do the sums in the dense kernels.
  // Wide blocks cost less per column, and an even number of them keeps two cores busy.
  const Eigen::Index blocks =
      b.cols() <= kNarrow ? 1 : 2 * ((b.cols() + 2 * kWide - 1) / (2 * kWide));
  const Eigen::Index width = (b.cols() + blocks - 1) / std::max<Eigen::Index>(1, blocks);
  std::vector<char> failed(blocks, 0);
  ParallelBlocks(b.cols(), width, [&](std::int64_t begin, std::int64_t end) {
    const OneOpenMpThread one_thread;
    SolveSpace space;
    cholmod_dense columns = ViewOf(b.data() + begin * b.rows(), b.rows(), end - begin);
    // CHOLMOD copies the right-hand side into y before it writes the solution
    cholmod_dense* x = &columns;
    const int ok = cholmod_solve2(CHOLMOD_A, impl_->factor, &columns, nullptr, &x, nullptr,
                                  &space.y, &space.e, &space.common);
    failed[begin / width] =
        !ok || x != &columns || !std::isfinite(b.middleCols(begin, end - begin).sum());
  });
  for (char f : failed)
    if (f) throw SolverError("sparse Cholesky: the solution is not finite");
}

SparseCholesky SparseCholesky::SameAnalysis() const {
  SparseCholesky copy;
  if (!impl_->factor) throw SolverError("sparse Cholesky: copy before analysis");
  copy.impl_->factor = cholmod_copy_factor(impl_->factor, &copy.impl_->common);
  if (!copy.impl_->factor) throw SolverError("sparse Cholesky: out of memory");
  if (copy.impl_->factor->xtype != CHOLMOD_PATTERN)
    throw SolverError("sparse Cholesky: copy an analysis before its first factorisation");
  return copy;
}

int SparseCholesky::analyze_calls() const { return impl_->analyze_calls; }
long SparseCholesky::factor_nonzeros() const { return static_cast<long>(impl_->common.lnz); }

}  // namespace keypose
