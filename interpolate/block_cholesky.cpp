#include "interpolate/block_cholesky.h"

#include <cholmod.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "core/errors.h"
#include "core/parallel.h"
#include "interpolate/lanes.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace keypose::interpolation {

/// Supernodes: columns first[s] .. first[s+1] share the rows at[s] .. at[s+1] of `row`, their own first; their entries begin at entry[s],
/// column by column.
struct BlockCholesky::Analysis {
  int size = 0, count = 0;
  std::vector<int> unknowns, rows;
  std::vector<int> first, at, row;
  std::vector<std::ptrdiff_t> entry, slots;  // slots: of the matrix's nonzeros, in the factor
  std::vector<int> parent;
  int most_rows = 0;

  int Width(int s) const { return first[s + 1] - first[s]; }
  int Rows(int s) const { return at[s + 1] - at[s]; }
};

namespace {

/// R x V vectors in registers, less the products of `count` rows of R numbers and V vectors: c -= a^T b.
template <int R, int V>
struct Tile {
  Lanes v[R][V];

  KEYPOSE_INLINE void Load(const double* const* c) {
#pragma GCC unroll 4
    for (int r = 0; r < R; ++r)
#pragma GCC unroll 4
      for (int k = 0; k < V; ++k) __builtin_memcpy(&v[r][k], c[r] + 4 * k, sizeof(Lanes));
  }
  KEYPOSE_INLINE void Store(double* const* c) const {
#pragma GCC unroll 4
    for (int r = 0; r < R; ++r)
#pragma GCC unroll 4
      for (int k = 0; k < V; ++k) __builtin_memcpy(c[r] + 4 * k, &v[r][k], sizeof(Lanes));
  }
  /// @param a, step  a[r * step]: the factor of row r
  KEYPOSE_INLINE void Subtract(const double* a, std::ptrdiff_t step, const double* b) {
    Lanes row[V];
#pragma GCC unroll 4
    for (int k = 0; k < V; ++k) __builtin_memcpy(&row[k], b + 4 * k, sizeof(Lanes));
#pragma GCC unroll 4
    for (int r = 0; r < R; ++r) {
      const Lanes factor = Spread(a[r * step]);
#pragma GCC unroll 4
      for (int k = 0; k < V; ++k) v[r][k] -= factor * row[k];
    }
  }
};

/// Calls work(R, offset) for blocks of four rows, then for what is left.
template <class Work>
KEYPOSE_INLINE void ByFour(int begin, int end, const Work& work) {
  int i = begin;
  for (; i + 4 <= end; i += 4) work(std::integral_constant<int, 4>(), i);
  switch (end - i) {
    case 1:
      return work(std::integral_constant<int, 1>(), i);
    case 2:
      return work(std::integral_constant<int, 2>(), i);
    case 3:
      return work(std::integral_constant<int, 3>(), i);
    default:
      return;
  }
}

/// One supernode and the rows of right-hand sides that it meets.
struct Panel {
  const double* l;  // column k at l + k * height
  std::ptrdiff_t height;
  int width;
  const int* row;
  const double* inverse;
};

template <int V>
KEYPOSE_INLINE void Forward(const Panel& p, double* x, std::ptrdiff_t stride) {
  double* own = x + p.row[0] * stride;
  ByFour(
      0, p.width, [&](auto r, int j) __attribute__((always_inline)) {
        constexpr int R = decltype(r)::value;
        double* c[R];
        for (int q = 0; q < R; ++q) c[q] = own + (j + q) * stride;
        Tile<R, V> tile;
        tile.Load(c);
        const double* a = p.l + j;
        for (int k = 0; k < j; ++k, a += p.height) tile.Subtract(a, 1, own + k * stride);
#pragma GCC unroll 4
        for (int q = 0; q < R; ++q) {
#pragma GCC unroll 4
          for (int v = 0; v < V; ++v) tile.v[q][v] *= Spread(p.inverse[j + q]);
#pragma GCC unroll 4
          for (int o = q + 1; o < R; ++o)
#pragma GCC unroll 4
            for (int v = 0; v < V; ++v) tile.v[o][v] -= Spread(p.l[(j + q) * p.height + j + o]) * tile.v[q][v];
        }
        tile.Store(c);
      });
  ByFour(
      p.width, static_cast<int>(p.height), [&](auto r, int i) __attribute__((always_inline)) {
        constexpr int R = decltype(r)::value;
        double* c[R];
        for (int q = 0; q < R; ++q) c[q] = x + p.row[i + q] * stride;
        Tile<R, V> tile;
        tile.Load(c);
        const double* a = p.l + i;
        for (int k = 0; k < p.width; ++k, a += p.height) tile.Subtract(a, 1, own + k * stride);
        tile.Store(c);
      });
}

template <int V>
KEYPOSE_INLINE void Backward(const Panel& p, double* x, std::ptrdiff_t stride) {
  double* own = x + p.row[0] * stride;
  const auto solve = [&](auto r, int j) __attribute__((always_inline)) {
    constexpr int R = decltype(r)::value;
    double* c[R];
    for (int q = 0; q < R; ++q) c[q] = own + (j + q) * stride;
    Tile<R, V> tile;
    tile.Load(c);
    const double* a = p.l + j * p.height;
    for (int i = j + R; i < static_cast<int>(p.height); ++i) tile.Subtract(a + i, p.height, x + p.row[i] * stride);
#pragma GCC unroll 4
    for (int q = R - 1; q >= 0; --q) {
#pragma GCC unroll 4
      for (int v = 0; v < V; ++v) tile.v[q][v] *= Spread(p.inverse[j + q]);
#pragma GCC unroll 4
      for (int o = 0; o < q; ++o)
#pragma GCC unroll 4
        for (int v = 0; v < V; ++v) tile.v[o][v] -= Spread(p.l[(j + o) * p.height + j + q]) * tile.v[q][v];
    }
    tile.Store(c);
  };
  const int left = p.width % 4;
  if (left == 1) solve(std::integral_constant<int, 1>(), p.width - 1);
  if (left == 2) solve(std::integral_constant<int, 2>(), p.width - 2);
  if (left == 3) solve(std::integral_constant<int, 3>(), p.width - 3);
  for (int j = p.width - left - 4; j >= 0; j -= 4) solve(std::integral_constant<int, 4>(), j);
}

/// One side of the solve on `columns` columns of one supernode, in tiles of twelve.
KEYPOSE_INLINE void SolvePanel(bool forward, const Panel& p, double* x, std::ptrdiff_t stride, int columns) {
  int c = 0;
  for (; c + 12 <= columns; c += 12) forward ? Forward<3>(p, x + c, stride) : Backward<3>(p, x + c, stride);
  if (columns - c == 8) forward ? Forward<2>(p, x + c, stride) : Backward<2>(p, x + c, stride);
  if (columns - c == 4) forward ? Forward<1>(p, x + c, stride) : Backward<1>(p, x + c, stride);
}

/// c -= a^T b on one tile: rows of a and b at distances, c at its own.
template <int R, int V>
KEYPOSE_INLINE void Update(const double* a, const double* b, std::ptrdiff_t distance, int count, double* c, std::ptrdiff_t c_distance) {
  double* rows[R];
  for (int r = 0; r < R; ++r) rows[r] = c + r * c_distance;
  Tile<R, V> tile;
  tile.Load(rows);
  for (int k = 0; k < count; ++k) tile.Subtract(a + k * distance, 1, b + k * distance);
  tile.Store(rows);
}

/// The same for columns begin .. end of c's R rows; those that fill no vector one by one.
template <int R>
KEYPOSE_INLINE void UpdateRows(const double* a, const double* b, std::ptrdiff_t distance, int count, double* c, std::ptrdiff_t c_distance,
                               int begin, int end) {
  int i = begin;
  for (; i + 12 <= end; i += 12) Update<R, 3>(a, b + i, distance, count, c + i, c_distance);
  for (; i + 4 <= end; i += 4) Update<R, 1>(a, b + i, distance, count, c + i, c_distance);
  for (; i < end; ++i)
    for (int r = 0; r < R; ++r) {
      double sum = 0;
      for (int k = 0; k < count; ++k) sum += a[k * distance + r] * b[k * distance + i];
      c[r * c_distance + i] -= sum;
    }
}

/// Cholesky factors of a supernode's columns, in place; false where a pivot is not positive.
KEYPOSE_INLINE bool FactorPanel(double* l, int width, int height, double* inverse) {
  bool good = true;
  ByFour(
      0, width, [&](auto r, int j) __attribute__((always_inline)) {
        constexpr int R = decltype(r)::value;
        double* rows = l + static_cast<std::ptrdiff_t>(j) * height;
        UpdateRows<R>(l + j, l, height, j, rows, height, j, height);
        for (int q = 0; q < R; ++q) {
          double* row = rows + static_cast<std::ptrdiff_t>(q) * height;
          const double pivot = row[j + q];
          good = good && pivot > 0;
          const double root = std::sqrt(pivot), scale = 1 / root;
          inverse[j + q] = scale;
          for (int i = j + q; i < height; ++i) row[i] *= scale;
          for (int o = q + 1; o < R; ++o) {
            double* other = rows + static_cast<std::ptrdiff_t>(o) * height;
            const double factor = row[j + o];
            for (int i = j + o; i < height; ++i) other[i] -= factor * row[i];
          }
        }
      });
  return good;
}

/// What the columns leave of the rows below: an upper triangle, m x m.
KEYPOSE_INLINE void Complement(const double* l, int width, int height, double* rest) {
  const int m = height - width;
  const double* below = l + width;
  ByFour(
      0, m, [&](auto r, int a) __attribute__((always_inline)) {
        constexpr int R = decltype(r)::value;
        UpdateRows<R>(below + a, below, height, width, rest + static_cast<std::ptrdiff_t>(a) * m, m, a, m);
      });
}

struct Kernels {
  void (*solve)(bool, const Panel&, double*, std::ptrdiff_t, int);
  bool (*factor)(double*, int, int, double*);
  void (*complement)(const double*, int, int, double*);
};

void SolvePlain(bool forward, const Panel& p, double* x, std::ptrdiff_t stride, int columns) { SolvePanel(forward, p, x, stride, columns); }
bool FactorPlain(double* l, int width, int height, double* inverse) { return FactorPanel(l, width, height, inverse); }
void ComplementPlain(const double* l, int width, int height, double* rest) { Complement(l, width, height, rest); }

KEYPOSE_FMA void SolveFma(bool forward, const Panel& p, double* x, std::ptrdiff_t stride, int columns) {
  SolvePanel(forward, p, x, stride, columns);
}
KEYPOSE_FMA bool FactorFma(double* l, int width, int height, double* inverse) { return FactorPanel(l, width, height, inverse); }
KEYPOSE_FMA void ComplementFma(const double* l, int width, int height, double* rest) { Complement(l, width, height, rest); }

Kernels BestKernels() {
  if (HasFma()) return {SolveFma, FactorFma, ComplementFma};
  return {SolvePlain, FactorPlain, ComplementPlain};
}

const Kernels kKernels = BestKernels();

constexpr double kMostZeros = 0.3;  // in a supernode of up to 16 columns; more make the factorisation no faster and the solves slower

/// CHOLMOD's workspace, for an analysis.
struct Workspace {
  Workspace() {
    cholmod_start(&common);
    common.print = 0;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_AMD;
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

BlockCholesky::BlockCholesky() = default;
BlockCholesky::~BlockCholesky() = default;
BlockCholesky::BlockCholesky(BlockCholesky&&) noexcept = default;
BlockCholesky& BlockCholesky::operator=(BlockCholesky&&) noexcept = default;

void BlockCholesky::Analyze(const Eigen::SparseMatrix<double>& lower) {
  if (!lower.isCompressed() || lower.rows() != lower.cols()) throw SolverError("sparse Cholesky: the matrix must be square and compressed");
  auto analysis = std::make_shared<Analysis>();
  Analysis& a = *analysis;
  a.size = static_cast<int>(lower.rows());
  Workspace work;
  cholmod_sparse view = PatternOf(lower);
  work.factor = cholmod_analyze(&view, &work.common);
  if (!work.factor) throw SolverError("sparse Cholesky: analysis failed, status " + std::to_string(work.common.status));
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
      const std::ptrdiff_t place = i < a.first[s + 1] ? i - a.first[s] : std::lower_bound(begin + a.Width(s), end, i) - begin;
      a.slots.push_back(a.entry[s] + static_cast<std::ptrdiff_t>(j - a.first[s]) * a.Rows(s) + place);
    }
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
  // What each supernode leaves for its parent waits in `rest` until the parent takes it in.
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
      const int m = a.Rows(child) - a.Width(child), *child_row = a.row.data() + a.at[child] + a.Width(child);
      for (int i = 0; i < m; ++i) local[i] = place[child_row[i]];
      const double* given = rest[child].data();
      for (int i = 0; i < m; ++i, given += m) {
        double* to = local[i] < width ? l + static_cast<std::ptrdiff_t>(local[i]) * height
                                      : own.data() + static_cast<std::ptrdiff_t>(local[i] - width) * below - width;
        for (int k = i; k < m; ++k) to[local[k]] += given[k];
      }
      std::vector<double>().swap(rest[child]);
    }
    if (!kKernels.factor(l, width, height, inverse_diagonal_.data() + a.first[s]))
      throw SolverError("sparse Cholesky: the system is not positive definite (near unknown " + std::to_string(a.unknowns[a.first[s]]) +
                        "); a part of the mesh is held by nothing");
    if (a.parent[s] >= 0) kKernels.complement(l, width, height, own.data());
  }
}

const std::vector<int>& BlockCholesky::unknowns() const { return analysis_->unknowns; }
const std::vector<int>& BlockCholesky::rows() const { return analysis_->rows; }
std::size_t BlockCholesky::factor_entries() const { return factor_.size(); }

void BlockCholesky::SolveRows(double* x, Eigen::Index columns) const {
  if (factor_.empty()) throw SolverError("sparse Cholesky: solve before factor");
  const Analysis& a = *analysis_;
  // Each thread takes some of the columns, in whole tiles, through all supernodes.
  const Eigen::Index tiles = (columns + 11) / 12, blocks = std::min<Eigen::Index>(ThreadCount(), tiles);
  const Eigen::Index width = 12 * ((tiles + blocks - 1) / std::max<Eigen::Index>(1, blocks));
  std::vector<char> failed(blocks, 0);
  ParallelBlocks(columns, width, [&](std::int64_t begin, std::int64_t end) {
    const auto pass = [&](bool forward, int s) {
      const Panel panel{factor_.data() + a.entry[s], a.Rows(s), a.Width(s), a.row.data() + a.at[s], inverse_diagonal_.data() + a.first[s]};
      kKernels.solve(forward, panel, x + begin, columns, static_cast<int>(end - begin));
    };
    for (int s = 0; s < a.count; ++s) pass(true, s);
    for (int s = a.count - 1; s >= 0; --s) pass(false, s);
    // What is not finite anywhere spreads to the last row of its part.
    for (int s = 0; s < a.count; ++s)
      for (std::int64_t c = begin; c < end && a.parent[s] < 0; ++c)
        if (!std::isfinite(x[static_cast<std::ptrdiff_t>(a.first[s + 1] - 1) * columns + c])) failed[begin / width] = 1;
  });
  if (std::count(failed.begin(), failed.end(), 1) > 0) throw SolverError("sparse Cholesky: the solution is not finite");
}

void BlockCholesky::SolveInPlace(Eigen::MatrixXd& x) const {
  const Analysis& a = *analysis_;
  const Eigen::Index width = Padded(x.cols());
  std::vector<double> buffer(static_cast<std::size_t>(a.size) * width, 0.0);
  for (int i = 0; i < a.size; ++i)
    for (Eigen::Index c = 0; c < x.cols(); ++c) buffer[i * width + c] = x(a.unknowns[i], c);
  SolveRows(buffer.data(), width);
  for (int i = 0; i < a.size; ++i)
    for (Eigen::Index c = 0; c < x.cols(); ++c) x(a.unknowns[i], c) = buffer[i * width + c];
}

}  // namespace keypose::interpolation
