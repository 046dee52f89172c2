#include "export/gltf/weighted_shapes.h"

#include <Eigen/Dense>
#include <algorithm>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

constexpr Eigen::Index kRowsPerBlock = 512;

}  // namespace

PointsX3 Blended(const MorphBasis& basis, Eigen::Index picture) {
  PointsX3 points = basis.base;
  for (int k = 0; k < SizeOf(basis.targets); ++k)
    points += basis.weights(picture, k) * basis.targets[k];
  return points;
}

Eigen::VectorXd VertexErrors(const Pictures& pictures, const MorphBasis& basis) {
  const Eigen::Index vertices = basis.base.rows();
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(vertices);
  ParallelBlocks(vertices, kRowsPerBlock, [&](std::int64_t begin, std::int64_t end) {
    const Eigen::Index rows = end - begin;
    PointsX3 rest;
    for (int p = 0; p < SizeOf(pictures); ++p) {
      rest = basis.base.middleRows(begin, rows) - pictures[p]->middleRows(begin, rows);
      for (int k = 0; k < SizeOf(basis.targets); ++k)
        rest += basis.weights(p, k) * basis.targets[k].middleRows(begin, rows);
      errors.segment(begin, rows) =
          errors.segment(begin, rows).cwiseMax(rest.rowwise().squaredNorm());
    }
  });
  return errors.cwiseSqrt();
}

MorphBasis LeastSquaresBasis(const Pictures& pictures, const Eigen::MatrixXd& weights) {
  const Eigen::Index vertices = pictures[0]->rows(), count = weights.cols();
  Eigen::MatrixXd system(weights.rows(), count + 1);
  system << Eigen::VectorXd::Ones(weights.rows()), weights;
  const Eigen::MatrixXd solve = system.completeOrthogonalDecomposition().pseudoInverse();
  MorphBasis basis{PointsX3::Zero(vertices, 3), {}, weights};
  basis.targets.assign(count, PointsX3::Zero(vertices, 3));
  ParallelBlocks(vertices, kRowsPerBlock, [&](std::int64_t begin, std::int64_t end) {
    for (int p = 0; p < SizeOf(pictures); ++p) {
      const auto points = pictures[p]->middleRows(begin, end - begin);
      basis.base.middleRows(begin, end - begin) += solve(0, p) * points;
      for (Eigen::Index k = 0; k < count; ++k)
        basis.targets[k].middleRows(begin, end - begin) += solve(k + 1, p) * points;
    }
  });
  return basis;
}

}  // namespace keypose::exporting
