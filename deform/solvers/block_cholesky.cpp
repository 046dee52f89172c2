#include "deform/solvers/block_cholesky.h"

#include <cholmod.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "deform/solvers/lanes.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace keypose {

/// Supernodes: the columns first[s] .. first[s+1] share the rows at[s] .. at[s+1] of `row`, which
/// start with their own. Their entries begin at entry[s], column by column.
struct BlockCholesky::Analysis {
  int size = 0, count = 0;
  std::vector<int> unknowns, rows;
  std::vector<int> first, at, row;
  std::vector<std::ptrdiff_t> entry, slots;  // slots: places in the factor of the matrix's nonzeros
  std::vector<int> parent;
  int most_rows = 0;
  /// Subtrees that are solved side by side in SolveFour: supernodes begin .. end - 1.
  struct Subtree {
    int begin, end;
  };
  std::vector<Subtree> subtrees;
  std::vector<int> top;        // supernodes of no subtree, in order
  std::vector<int> local_row;  // as `row`, counted from the subtree's first unknown; rows beyond
                               // the subtree follow in the order of its root's

  void CutSubtrees();

  int Width(int s) const { return first[s + 1] - first[s]; }
  int Rows(int s) const { return at[s + 1] - at[s]; }
};

namespace {

/// One supernode and its rows of the right-hand sides.
struct Panel {
  const double* l;  // column k at l + k * height
  std::ptrdiff_t height;
  int width;
  const int* row;
  const double* inverse;
};

}  // namespace

namespace plain {
#include "deform/solvers/block_cholesky.inc"
}
KEYPOSE_FUSED_BEGIN
namespace fused {
#include "deform/solvers/block_cholesky.inc"
}
KEYPOSE_FUSED_END

namespace {

struct Kernels {
  void (*solve)(bool, const Panel&, double*, std::ptrdiff_t, int);
  bool (*factor)(double*, int, int, double*);
  void (*complement)(const double*, int, int, double*);
};

Kernels BestKernels() {
  if (HasFused()) return {fused::SolvePanel, fused::FactorPanel, fused::Complement};
  return {plain::SolvePanel, plain::FactorPanel, plain::Complement};
}

const Kernels kKernels = BestKernels();

constexpr int kLeastSubtrees = 16;  // each has at most one in so many of the factor's entries
constexpr double kMostZeros = 0.3;  // in a supernode of up to 16 columns; more zeros make solves
                                    // slower and the factorisation no faster

/// CHOLMOD's workspace, for an analysis.
struct Workspace {
  Workspace() {
    cholmod_start(&common);
    common.print = 0;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.zrelax[0] = kMostZeros;
  }
  ~Workspace() {
    if (factor) cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  cholmod_common common{};
  cholmod_factor* factor = nullptr;
};

cholmod_sparse PatternOf(const Eigen::SparseMatrix<double>& lower) {
  cholmod_sparse view{};
  view.nrow = view.ncol = static_cast<std::size_t>(lower.rows());
  view.nzmax = static_cast<std::size_t>(lower.nonZeros());
  view.p = const_cast<int*>(lower.outerIndexPtr());
  view.i = const_cast<int*>(lower.innerIndexPtr());
  view.stype = -1;
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_PATTERN;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = view.packed = 1;
  return view;
}

}  // namespace

/// Supernodes are in postorder, so that a subtree is a range that ends with its root.
void BlockCholesky::Analysis::CutSubtrees() {
  std::vector<std::ptrdiff_t> work(count);
  std::vector<int> begin(count);
  for (int s = 0; s < count; ++s) begin[s] = s;
  for (int s = 0; s < count; ++s) {
    work[s] += entry[s + 1] - entry[s];
    if (parent[s] < 0) continue;
    work[parent[s]] += work[s];
    begin[parent[s]] = std::min(begin[parent[s]], begin[s]);
  }
  const std::ptrdiff_t most = entry.back() / kLeastSubtrees;
  for (int s = 0; s < count; ++s)
    if (work[s] <= most && (parent[s] < 0 || work[parent[s]] > most))
      subtrees.push_back({begin[s], s + 1});
    else if (work[s] > most)
      top.push_back(s);
  local_row = row;
  for (const Subtree& tree : subtrees) {
    const int root = tree.end - 1, base = first[tree.begin], inside = first[tree.end] - base;
    const int *beyond = row.data() + at[root] + Width(root), *end = row.data() + at[root + 1];
    for (int k = at[tree.begin]; k < at[tree.end]; ++k)
      local_row[k] =
          row[k] < first[tree.end]
              ? row[k] - base
              : inside + static_cast<int>(std::lower_bound(beyond, end, row[k]) - beyond);
  }
}

BlockCholesky::BlockCholesky() = default;
BlockCholesky::~BlockCholesky() = default;
BlockCholesky::BlockCholesky(BlockCholesky&&) noexcept = default;
BlockCholesky& BlockCholesky::operator=(BlockCholesky&&) noexcept = default;

void BlockCholesky::Analyze(const Eigen::SparseMatrix<double>& lower, bool dissected) {
  if (!lower.isCompressed() || lower.rows() != lower.cols())
    throw SolverError("sparse Cholesky: the matrix must be square and compressed");
  auto analysis = std::make_shared<Analysis>();
  Analysis& a = *analysis;
  a.size = static_cast<int>(lower.rows());
  Workspace work;
  if (dissected) {
    work.common.nmethods = 1;
    work.common.method[0].ordering = CHOLMOD_METIS;
  }
  cholmod_sparse view = PatternOf(lower);
  work.factor = cholmod_analyze(&view, &work.common);
  if (!work.factor)
    throw SolverError("sparse Cholesky: analysis failed, status " +
                      std::to_string(work.common.status));
  const cholmod_factor& f = *work.factor;
  const auto ints = [](const void* data, std::size_t count) {
    return std::vector<int>(static_cast<const int*>(data), static_cast<const int*>(data) + count);
  };
  a.count = static_cast<int>(f.nsuper);
  a.unknowns = ints(f.Perm, f.n);
  a.first = ints(f.super, f.nsuper + 1);
  a.at = ints(f.pi, f.nsuper + 1);
  a.row = ints(f.s, f.ssize);
  a.rows.resize(a.size);
  for (int i = 0; i < a.size; ++i) a.rows[a.unknowns[i]] = i;
  a.entry.assign(1, 0);
  std::vector<int> node(a.size);
  for (int s = 0; s < a.count; ++s) {
    a.entry.push_back(a.entry.back() + static_cast<std::ptrdiff_t>(a.Width(s)) * a.Rows(s));
    a.most_rows = std::max(a.most_rows, a.Rows(s));
    std::fill(node.begin() + a.first[s], node.begin() + a.first[s + 1], s);
  }
  a.parent.assign(a.count, -1);
  for (int s = 0; s < a.count; ++s)
    if (a.Rows(s) > a.Width(s)) a.parent[s] = node[a.row[a.at[s] + a.Width(s)]];
  a.slots.reserve(lower.nonZeros());
  for (int column = 0; column < a.size; ++column)
    for (int k = lower.outerIndexPtr()[column]; k < lower.outerIndexPtr()[column + 1]; ++k) {
      const auto [j, i] = std::minmax(a.rows[column], a.rows[lower.innerIndexPtr()[k]]);
      const int s = node[j], *begin = a.row.data() + a.at[s], *end = begin + a.Rows(s);
      const std::ptrdiff_t place = i < a.first[s + 1]
                                       ? i - a.first[s]
                                       : std::lower_bound(begin + a.Width(s), end, i) - begin;
      a.slots.push_back(a.entry[s] + static_cast<std::ptrdiff_t>(j - a.first[s]) * a.Rows(s) +
                        place);
    }
  a.CutSubtrees();
  analysis_ = std::move(analysis);
}

BlockCholesky BlockCholesky::SameAnalysis() const {
  BlockCholesky other;
  other.analysis_ = analysis_;
  return other;
}

void BlockCholesky::Factor(const Eigen::SparseMatrix<double>& lower) {
  const Analysis& a = *analysis_;
  factor_.assign(a.entry.back(), 0.0);
  inverse_diagonal_.resize(a.size);
  for (std::size_t k = 0; k < a.slots.size(); ++k) factor_[a.slots[k]] += lower.valuePtr()[k];
  // `rest` holds the update matrix of each supernode until its parent adds it.
  std::vector<std::vector<double>> rest(a.count);
  std::vector<int> first_child(a.count, -1), next(a.count, -1), place(a.size), local(a.most_rows);
  for (int s = a.count - 1; s >= 0; --s)
    if (a.parent[s] >= 0) next[s] = std::exchange(first_child[a.parent[s]], s);
  for (int s = 0; s < a.count; ++s) {
    const int width = a.Width(s), height = a.Rows(s), below = height - width;
    const int* row = a.row.data() + a.at[s];
    double* l = factor_.data() + a.entry[s];
    std::vector<double>& own = rest[s];
    own.assign(static_cast<std::size_t>(below) * below, 0.0);
    for (int i = 0; i < height; ++i) place[row[i]] = i;
    for (int child = first_child[s]; child >= 0; child = next[child]) {
      const int m = a.Rows(child) - a.Width(child),
                *child_row = a.row.data() + a.at[child] + a.Width(child);
      for (int i = 0; i < m; ++i) local[i] = place[child_row[i]];
      const double* given = rest[child].data();
      for (int i = 0; i < m; ++i, given += m) {
        double* to =
            local[i] < width
                ? l + static_cast<std::ptrdiff_t>(local[i]) * height
                : own.data() + static_cast<std::ptrdiff_t>(local[i] - width) * below - width;
        for (int k = i; k < m; ++k) to[local[k]] += given[k];
      }
      std::vector<double>().swap(rest[child]);
    }
    if (!kKernels.factor(l, width, height, inverse_diagonal_.data() + a.first[s]))
      throw SolverError("sparse Cholesky: the system is not positive definite (near unknown " +
                        std::to_string(a.unknowns[a.first[s]]) +
                        "); a part of the mesh has no constraint");
    if (a.parent[s] >= 0) kKernels.complement(l, width, height, own.data());
  }
}

const std::vector<int>& BlockCholesky::unknowns() const { return analysis_->unknowns; }
const std::vector<int>& BlockCholesky::rows() const { return analysis_->rows; }
std::size_t BlockCholesky::factor_entries() const { return factor_.size(); }

void BlockCholesky::SolveRows(double* x, Eigen::Index columns) const {
  if (factor_.empty()) throw SolverError("sparse Cholesky: solve before factor");
  const Analysis& a = *analysis_;
  // Each thread solves some of the columns, in whole tiles, through all supernodes.
  const Eigen::Index tiles = (columns + 11) / 12,
                     blocks = std::min<Eigen::Index>(ThreadCount(), tiles);
  const Eigen::Index width = 12 * ((tiles + blocks - 1) / std::max<Eigen::Index>(1, blocks));
  std::vector<char> failed(blocks, 0);
  ParallelBlocks(columns, width, [&](std::int64_t begin, std::int64_t end) {
    const auto pass = [&](bool forward, int s) {
      const Panel panel{factor_.data() + a.entry[s], a.Rows(s), a.Width(s), a.row.data() + a.at[s],
                        inverse_diagonal_.data() + a.first[s]};
      kKernels.solve(forward, panel, x + begin, columns, static_cast<int>(end - begin));
    };
    for (int s = 0; s < a.count; ++s) pass(true, s);
    for (int s = a.count - 1; s >= 0; --s) pass(false, s);
    // A value that is not finite spreads to the last row of its connected part.
    for (int s = 0; s < a.count; ++s)
      for (std::int64_t c = begin; c < end && a.parent[s] < 0; ++c)
        if (!std::isfinite(x[static_cast<std::ptrdiff_t>(a.first[s + 1] - 1) * columns + c]))
          failed[begin / width] = 1;
  });
  if (std::count(failed.begin(), failed.end(), 1) > 0)
    throw SolverError("sparse Cholesky: the solution is not finite");
}

/// Solves the subtree's rows of x on a copy. Forward, what it leaves to rows beyond it is returned,
/// in the order of its root's rows; backward, they are read.
double* BlockCholesky::SolveSubtree(bool forward, int subtree, double* x,
                                    std::vector<double>& own) const {
  const Analysis& a = *analysis_;
  const auto [begin, end] = a.subtrees[subtree];
  const int root = end - 1, base = a.first[begin], size = a.first[end] - base,
            beyond = a.Rows(root) - a.Width(root);
  own.assign(static_cast<std::size_t>(size + beyond) * 4, 0.0);
  std::copy_n(x + static_cast<std::ptrdiff_t>(base) * 4, size * 4, own.data());
  const int* row = a.row.data() + a.at[root] + a.Width(root);
  double* rest = own.data() + static_cast<std::ptrdiff_t>(size) * 4;
  for (int i = 0; i < beyond && !forward; ++i)
    std::copy_n(x + static_cast<std::ptrdiff_t>(row[i]) * 4, 4, rest + i * 4);
  for (int k = 0; k < end - begin; ++k) {
    const int s = forward ? begin + k : end - 1 - k;
    const Panel panel{factor_.data() + a.entry[s], a.Rows(s), a.Width(s),
                      a.local_row.data() + a.at[s], inverse_diagonal_.data() + a.first[s]};
    kKernels.solve(forward, panel, own.data(), 4, 4);
  }
  std::copy_n(own.data(), size * 4, x + static_cast<std::ptrdiff_t>(base) * 4);
  return rest;
}

void BlockCholesky::SolveFour(double* x) const {
  if (factor_.empty()) throw SolverError("sparse Cholesky: solve before factor");
  const Analysis& a = *analysis_;
  const auto pass = [&](bool forward, int s) {
    const Panel panel{factor_.data() + a.entry[s], a.Rows(s), a.Width(s), a.row.data() + a.at[s],
                      inverse_diagonal_.data() + a.first[s]};
    kKernels.solve(forward, panel, x, 4, 4);
  };
  const int count = static_cast<int>(a.subtrees.size());
  std::vector<std::vector<double>> left(count);
  ParallelFor(count, [&](std::int64_t k) {
    std::vector<double> own;
    const double* rest = SolveSubtree(true, static_cast<int>(k), x, own);
    left[k].assign(rest, static_cast<const double*>(own.data() + own.size()));
  });
  for (int k = 0; k < count; ++k) {
    const int root = a.subtrees[k].end - 1, *row = a.row.data() + a.at[root] + a.Width(root);
    for (std::size_t i = 0; i < left[k].size(); ++i)
      x[row[i / 4] * std::ptrdiff_t{4} + i % 4] += left[k][i];
  }
  for (const int s : a.top) pass(true, s);
  for (std::size_t k = a.top.size(); k-- > 0;) pass(false, a.top[k]);
  ParallelFor(count, [&](std::int64_t k) {
    std::vector<double> own;
    SolveSubtree(false, static_cast<int>(k), x, own);
  });
  // A value that is not finite spreads to the last row of its connected part.
  for (int s = 0; s < a.count; ++s)
    for (int c = 0; c < 4 && a.parent[s] < 0; ++c)
      if (!std::isfinite(x[(a.first[s + 1] - 1) * std::ptrdiff_t{4} + c]))
        throw SolverError("sparse Cholesky: the solution is not finite");
}

void BlockCholesky::SolveInPlace(Eigen::MatrixXd& x) const {
  if (factor_.empty()) throw SolverError("sparse Cholesky: solve before factor");
  const Analysis& a = *analysis_;
  const Eigen::Index width = Padded(x.cols());
  std::vector<double> buffer(static_cast<std::size_t>(a.size) * width, 0.0);
  for (int i = 0; i < a.size; ++i)
    for (Eigen::Index c = 0; c < x.cols(); ++c) buffer[i * width + c] = x(a.unknowns[i], c);
  SolveRows(buffer.data(), width);
  for (int i = 0; i < a.size; ++i)
    for (Eigen::Index c = 0; c < x.cols(); ++c) x(a.unknowns[i], c) = buffer[i * width + c];
}

}  // namespace keypose
