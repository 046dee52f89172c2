#include "register/intrinsic/functional_map.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/numbers/parallel.h"
#include "deform/solvers/dense_product.h"

namespace keypose::registration {

namespace {

Eigen::MatrixXf TransposedProduct(const Eigen::Ref<const Eigen::MatrixXf>& a,
                                  const Eigen::Ref<const Eigen::MatrixXf>& b) {
  Eigen::MatrixXf product(a.cols(), b.cols());
  Multiply(1.0f, a, b, Flip::kFirst, 0, product);
  return product;
}

Eigen::MatrixXf Gathered(const Eigen::MatrixXf& rows, const std::vector<int>& which,
                         Eigen::Index columns) {
  Eigen::MatrixXf picked(std::ssize(which), columns);
  for (Eigen::Index k = 0; k < columns; ++k)
    for (std::size_t i = 0; i < which.size(); ++i)
      picked(static_cast<Eigen::Index>(i), k) = rows(which[i], k);
  return picked;
}

/// The matrix C that minimises the weighted |from C - to(map)|^2. A small ridge term keeps
/// functions that the points do not resolve near zero.
Eigen::MatrixXf FitPull(const SpectralPoints& from, const Eigen::MatrixXf& to,
                        const std::vector<int>& map, Eigen::Index size) {
  const auto phi = from.functions.leftCols(size);
  const Eigen::MatrixXf weighted = from.weights.asDiagonal() * phi;
  Eigen::MatrixXf normal = TransposedProduct(phi, weighted);
  normal.diagonal().array() += 1e-3f;
  return normal.llt().solve(TransposedProduct(weighted, Gathered(to, map, size)));
}

float Variance(const Eigen::Ref<const Eigen::MatrixXf>& rows) {
  if (rows.size() == 0) return 0;
  float sum = 0;
  for (Eigen::Index k = 0; k < rows.cols(); ++k)
    sum += (rows.col(k).array() - rows.col(k).mean()).matrix().squaredNorm();
  return sum / static_cast<float>(rows.rows());
}

/// Index of the smallest value, the first if several are equal; 0 if all are NaN. Works on runs of
/// values, so that the compiler can use vector instructions.
int FirstLeast(const Eigen::Ref<const Eigen::VectorXf>& values) {
  constexpr Eigen::Index kRun = 128;
  float least = std::numeric_limits<float>::infinity();
  Eigen::Index at = 0;
  for (Eigen::Index k = 0; k < values.size(); k += kRun) {
    const float lowest = values.segment(k, std::min(kRun, values.size() - k)).minCoeff();
    if (lowest < least) {
      least = lowest;
      at = k;
    }
  }
  for (Eigen::Index k = at; k < values.size(); ++k)
    if (values[k] == least) return static_cast<int>(k);
  return 0;
}

/// For each row the smallest value and its first column; -1 where all are NaN or infinite. Works on
/// a few columns at a time, for speed.
void LeastOfRows(const Eigen::MatrixXf& values, Eigen::VectorXf& least, Eigen::VectorXi& column) {
  constexpr Eigen::Index kTogether = 4;
  least.setConstant(values.rows(), std::numeric_limits<float>::infinity());
  column.setConstant(values.rows(), -1);
  Eigen::VectorXf lowest(values.rows());
  for (Eigen::Index first = 0; first < values.cols(); first += kTogether) {
    const Eigen::Index count = std::min(kTogether, values.cols() - first);
    lowest = values.col(first);
    for (Eigen::Index k = 1; k < count; ++k) lowest = lowest.cwiseMin(values.col(first + k));
    for (Eigen::Index j = 0; j < values.rows(); ++j) {
      if (!(lowest[j] < least[j])) continue;
      least[j] = lowest[j];
      Eigen::Index k = 0;
      while (values(j, first + k) != lowest[j]) ++k;
      column[j] = static_cast<int>(first + k);
    }
  }
}

}  // namespace

PointMaps NearestRows(const Eigen::MatrixXf& a, const Eigen::MatrixXf& b) {
  constexpr Eigen::Index kBlock = 128;
  const Eigen::VectorXf a_squared = a.rowwise().squaredNorm(),
                        b_squared = b.rowwise().squaredNorm();
  const Eigen::Index blocks = (a.rows() + kBlock - 1) / kBlock;
  PointMaps maps{std::vector<int>(static_cast<std::size_t>(a.rows()), 0),
                 std::vector<int>(static_cast<std::size_t>(b.rows()), 0)};
  // The best match of each row of b within each block. The blocks are combined in order afterwards.
  std::vector<Eigen::VectorXf> least(static_cast<std::size_t>(blocks));
  std::vector<Eigen::VectorXi> column(static_cast<std::size_t>(blocks));
  ParallelFor(blocks, [&](std::int64_t block) {
    const Eigen::Index begin = block * kBlock, count = std::min(kBlock, a.rows() - begin);
    Eigen::MatrixXf cost(b.rows(), count);
    Multiply(-2.0f, b, a.middleRows(begin, count), Flip::kSecond, 0, cost);
    for (Eigen::Index i = 0; i < count; ++i) {
      cost.col(i) += b_squared;  // a's norm is constant in a column; it matters only for rows
      maps.forward[begin + i] = FirstLeast(cost.col(i));
      cost.col(i).array() += a_squared[begin + i];
    }
    LeastOfRows(cost, least[block], column[block]);
  });
  for (Eigen::Index j = 0; j < b.rows(); ++j) {
    float best = std::numeric_limits<float>::infinity();
    for (std::size_t block = 0; block < least.size(); ++block)
      if (least[block][j] < best) {
        best = least[block][j];
        maps.backward[j] = static_cast<int>(block) * kBlock + column[block][j];
      }
  }
  return maps;
}

Eigen::MatrixXf JointEmbedding::SourceRows(const Eigen::MatrixXf& functions) const {
  const Eigen::Index size = pull_forward.rows();
  Eigen::MatrixXf rows(functions.rows(), 2 * size);
  Multiply(1.0f, functions.leftCols(size), pull_forward, Flip::kNone, 0, rows.leftCols(size));
  rows.rightCols(size) = functions.leftCols(size);
  return rows;
}

Eigen::MatrixXf JointEmbedding::TargetRows(const Eigen::MatrixXf& functions) const {
  const Eigen::Index size = pull_backward.rows();
  Eigen::MatrixXf rows(functions.rows(), 2 * size);
  rows.leftCols(size) = functions.leftCols(size);
  Multiply(1.0f, functions.leftCols(size), pull_backward, Flip::kNone, 0, rows.rightCols(size));
  return rows;
}

JointEmbedding FitEmbedding(const SpectralPoints& source, const SpectralPoints& target,
                            const PointMaps& maps, int size) {
  const Eigen::Index k =
      std::min({static_cast<Eigen::Index>(size), source.functions.cols(), target.functions.cols()});
  return {FitPull(source, target.functions, maps.forward, k),
          FitPull(target, source.functions, maps.backward, k)};
}

PointMaps RefineMaps(const SpectralPoints& source, const SpectralPoints& target, PointMaps start,
                     const std::vector<int>& sizes, const MatchHints& hints) {
  const float spread = Variance(hints.source);
  for (const int size : sizes) {
    const JointEmbedding joint = FitEmbedding(source, target, start, size);
    Eigen::MatrixXf a = joint.SourceRows(source.functions), b = joint.TargetRows(target.functions);
    if (spread > 0 && hints.weight > 0) {
      const float scale = std::sqrt(static_cast<float>(hints.weight) * Variance(a) / spread);
      const Eigen::Index plain = a.cols();
      a.conservativeResize(Eigen::NoChange, plain + hints.source.cols());
      b.conservativeResize(Eigen::NoChange, plain + hints.target.cols());
      a.rightCols(hints.source.cols()) = scale * hints.source;
      b.rightCols(hints.target.cols()) = scale * hints.target;
    }
    start = NearestRows(a, b);
  }
  return start;
}

}  // namespace keypose::registration
