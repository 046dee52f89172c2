#include "interpolate/volume/tet_maps.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "core/numbers/parallel.h"

namespace keypose::interpolation {

namespace {

constexpr double kFlat = 1e-6;  // smallest stretch over the largest of a usable map

Eigen::Matrix3d Cofactors(const Eigen::Matrix3d& j) {
  Eigen::Matrix3d c;
  c.col(0) = j.col(1).cross(j.col(2));
  c.col(1) = j.col(2).cross(j.col(0));
  c.col(2) = j.col(0).cross(j.col(1));
  return c;
}

Eigen::Matrix3d RotationBySingularValues(const Eigen::Matrix3d& j) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(j, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
  return u * svd.matrixV().transpose();
}

}  // namespace

std::vector<TetShape> TetShapesOf(const PointsX3& points, const TetsX4& tets) {
  std::vector<TetShape> shapes(tets.rows());
  ParallelFor(
      tets.rows(),
      [&](std::int64_t t) {
        Eigen::Matrix3d edges;
        for (int k = 0; k < 3; ++k)
          edges.col(k) = (points.row(tets(t, k + 1)) - points.row(tets(t, 0))).transpose();
        const double det = edges.determinant();
        shapes[t].gradients.rightCols<3>() = Cofactors(edges) / det;
        shapes[t].gradients.col(0) = -shapes[t].gradients.rightCols<3>().rowwise().sum();
        shapes[t].volume = det / 6;
      },
      512);
  return shapes;
}

Eigen::Matrix3d MapOf(const TetShape& shape, const PointsX3& to, const TetsX4& tets,
                      Eigen::Index t) {
  // From edges, not corners: accurate far from the origin.
  Eigen::Matrix3d j = Eigen::Matrix3d::Zero();
  for (int k = 1; k < 4; ++k)
    j += (to.row(tets(t, k)) - to.row(tets(t, 0))).transpose() * shape.gradients.col(k).transpose();
  return j;
}

Eigen::Matrix3d ClosestRotation(const Eigen::Matrix3d& j) {
  const double size = j.norm();
  if (!(j.determinant() > 1e-4 * size * size * size)) return RotationBySingularValues(j);
  Eigen::Matrix3d x = j;
  for (int round = 0; round < 20; ++round) {
    const Eigen::Matrix3d inverse = Cofactors(x) / x.determinant();  // transposed
    const double scale = std::sqrt(inverse.norm() / x.norm());
    const Eigen::Matrix3d next = 0.5 * (scale * x + inverse / scale);
    const double change = (next - x).squaredNorm();
    x = next;
    if (change < 1e-16) break;  // quadratic convergence: the next change would be below 1e-16
  }
  return x;
}

std::vector<TetMap> TetMapsOf(const std::vector<TetShape>& shapes, const PointsX3& to,
                              const TetsX4& tets) {
  std::vector<TetMap> maps(tets.rows());
  ParallelFor(
      tets.rows(),
      [&](std::int64_t t) {
        const Eigen::JacobiSVD<Eigen::Matrix3d> svd(MapOf(shapes[t], to, tets, t),
                                                    Eigen::ComputeFullU | Eigen::ComputeFullV);
        TetMap& map = maps[t];
        map.axes = svd.matrixV();
        map.stretch = svd.singularValues();
        Eigen::Matrix3d u = svd.matrixU();
        if ((u * map.axes.transpose()).determinant() < 0) {
          u.col(2) = -u.col(2);
          map.stretch[2] = -map.stretch[2];
        }
        map.rotation = u * map.axes.transpose();
        map.inverted = !(map.stretch[2] > kFlat * map.stretch[0]);
      },
      256);
  return maps;
}

CornerSums::CornerSums(Eigen::Index point_count, const TetsX4& tets)
    : first_(point_count + 1, 0), corners_(4 * tets.rows()) {
  for (Eigen::Index t = 0; t < tets.rows(); ++t)
    for (int k = 0; k < 4; ++k) ++first_[tets(t, k) + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  std::vector<int> at(first_.begin(), first_.end() - 1);
  for (Eigen::Index t = 0; t < tets.rows(); ++t)
    for (int k = 0; k < 4; ++k) corners_[at[tets(t, k)]++] = static_cast<int>(4 * t + k);
}

PointsX3 CornerSums::Sum(
    const std::function<void(std::int64_t, Eigen::Matrix<double, 3, 4>&)>& term) const {
  std::vector<Eigen::Matrix<double, 3, 4>> terms(corners_.size() / 4);
  ParallelFor(
      std::ssize(terms), [&](std::int64_t t) { term(t, terms[t]); }, 256);
  const Eigen::Index n = std::ssize(first_) - 1;
  PointsX3 sums(n, 3);
  ParallelFor(
      n,
      [&](std::int64_t i) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int at = first_[i]; at < first_[i + 1]; ++at)
          sum += terms[corners_[at] / 4].col(corners_[at] % 4);
        sums.row(i) = sum.transpose();
      },
      1024);
  return sums;
}

Eigen::SparseMatrix<double> LaplacianOf(
    Eigen::Index point_count, const TetsX4& tets, const std::vector<TetShape>& shapes,
    const std::function<Eigen::Matrix3d(std::int64_t)>& weight) {
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(10 * tets.rows());
  for (Eigen::Index t = 0; t < tets.rows(); ++t) {
    const Eigen::Matrix4d local = shapes[t].gradients.transpose() * weight(t) * shapes[t].gradients;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b <= a; ++b)
        triplets.emplace_back(std::max(tets(t, a), tets(t, b)), std::min(tets(t, a), tets(t, b)),
                              local(a, b));
  }
  Eigen::SparseMatrix<double> laplacian(point_count, point_count);
  laplacian.setFromTriplets(triplets.begin(), triplets.end());
  return laplacian;
}

}  // namespace keypose::interpolation
