#include "register/functional_map.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace keypose::registration {

namespace {

Eigen::MatrixXf Gathered(const Eigen::MatrixXf& rows, const std::vector<int>& which, Eigen::Index columns) {
  Eigen::MatrixXf picked(static_cast<Eigen::Index>(which.size()), columns);
  for (Eigen::Index k = 0; k < columns; ++k)
    for (std::size_t i = 0; i < which.size(); ++i) picked(static_cast<Eigen::Index>(i), k) = rows(which[i], k);
  return picked;
}

/// C of least weighted |from C - to(map)|^2. The ridge holds functions that the points do not resolve near zero.
Eigen::MatrixXf FitPull(const SpectralPoints& from, const Eigen::MatrixXf& to, const std::vector<int>& map, Eigen::Index size) {
  const auto phi = from.functions.leftCols(size);
  const Eigen::MatrixXf weighted = from.weights.asDiagonal() * phi;
  Eigen::MatrixXf normal = phi.transpose() * weighted;
  normal.diagonal().array() += 1e-3f;
  return normal.llt().solve(weighted.transpose() * Gathered(to, map, size));
}

float Variance(const Eigen::MatrixXf& rows) {
  if (rows.size() == 0) return 0;
  return (rows.rowwise() - rows.colwise().mean()).squaredNorm() / static_cast<float>(rows.rows());
}

Eigen::MatrixXf Beside(const Eigen::MatrixXf& a, const Eigen::MatrixXf& b) {
  Eigen::MatrixXf both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

}  // namespace

PointMaps NearestRows(const Eigen::MatrixXf& a, const Eigen::MatrixXf& b) {
  constexpr Eigen::Index kBlock = 128;
  const Eigen::VectorXf a_squared = a.rowwise().squaredNorm(), b_squared = b.rowwise().squaredNorm();
  const Eigen::Index blocks = (a.rows() + kBlock - 1) / kBlock;
  PointMaps maps{std::vector<int>(static_cast<std::size_t>(a.rows()), 0), std::vector<int>(static_cast<std::size_t>(b.rows()), 0)};
  Eigen::MatrixXf best(b.rows(), blocks);  // of each row of b within each block, reduced in order afterwards
  Eigen::MatrixXi best_row(b.rows(), blocks);
  ParallelFor(blocks, [&](std::int64_t block) {
    const Eigen::Index begin = block * kBlock, count = std::min(kBlock, a.rows() - begin);
    Eigen::MatrixXf cost = -2 * (b * a.middleRows(begin, count).transpose());
    cost.colwise() += b_squared;  // row minima need a's norm as well, column minima do not
    for (Eigen::Index i = 0; i < count; ++i) {
      Eigen::Index at = 0;
      cost.col(i).minCoeff(&at);
      maps.forward[static_cast<std::size_t>(begin + i)] = static_cast<int>(at);
    }
    best.col(block).setConstant(std::numeric_limits<float>::infinity());
    for (Eigen::Index i = 0; i < count; ++i)
      for (Eigen::Index j = 0; j < b.rows(); ++j) {
        const float c = cost(j, i) + a_squared[begin + i];
        if (c < best(j, block)) best(j, block) = c, best_row(j, block) = static_cast<int>(begin + i);
      }
  });
  for (Eigen::Index j = 0; j < b.rows(); ++j) {
    Eigen::Index block = 0;
    best.row(j).minCoeff(&block);
    maps.backward[static_cast<std::size_t>(j)] = best_row(j, block);
  }
  return maps;
}

Eigen::MatrixXf JointEmbedding::SourceRows(const Eigen::MatrixXf& functions) const {
  const Eigen::Index size = pull_forward.rows();
  Eigen::MatrixXf rows(functions.rows(), 2 * size);
  rows.leftCols(size).noalias() = functions.leftCols(size) * pull_forward;
  rows.rightCols(size) = functions.leftCols(size);
  return rows;
}

Eigen::MatrixXf JointEmbedding::TargetRows(const Eigen::MatrixXf& functions) const {
  const Eigen::Index size = pull_backward.rows();
  Eigen::MatrixXf rows(functions.rows(), 2 * size);
  rows.leftCols(size) = functions.leftCols(size);
  rows.rightCols(size).noalias() = functions.leftCols(size) * pull_backward;
  return rows;
}

JointEmbedding FitEmbedding(const SpectralPoints& source, const SpectralPoints& target, const PointMaps& maps, int size) {
  const Eigen::Index k = std::min({static_cast<Eigen::Index>(size), source.functions.cols(), target.functions.cols()});
  return {FitPull(source, target.functions, maps.forward, k), FitPull(target, source.functions, maps.backward, k)};
}

PointMaps RefineMaps(const SpectralPoints& source, const SpectralPoints& target, PointMaps start, const std::vector<int>& sizes,
                     const MatchHints& hints) {
  const float spread = Variance(hints.source);
  for (const int size : sizes) {
    const JointEmbedding joint = FitEmbedding(source, target, start, size);
    Eigen::MatrixXf a = joint.SourceRows(source.functions), b = joint.TargetRows(target.functions);
    if (spread > 0 && hints.weight > 0) {
      const float scale = std::sqrt(static_cast<float>(hints.weight) * Variance(a) / spread);
      a = Beside(a, scale * hints.source);
      b = Beside(b, scale * hints.target);
    }
    start = NearestRows(a, b);
  }
  return start;
}

}  // namespace keypose::registration
