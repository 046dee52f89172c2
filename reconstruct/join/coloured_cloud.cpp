#include "reconstruct/join/coloured_cloud.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {
namespace {

/// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct CloudPolishTuning {
  KEYPOSE_TUNED(int, kNeighbors, 12);    ///< points to which a plane is fitted
  KEYPOSE_TUNED(double, kRobust, 0.15);  ///< of the largest distance: scale of the Cauchy weight
};

/// Normals of planes fitted to each point's neighbours, with arbitrary sign.
PointsX3 PlaneNormals(const Cloud& cloud, const KdTree& tree) {
  PointsX3 normals(cloud.size(), 3);
  ParallelFor(
      cloud.size(),
      [&](std::int64_t i) {
        const auto near =
            tree.Nearest(cloud.points.row(i).transpose(), CloudPolishTuning::kNeighbors);
        Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
        for (const KdTree::Neighbor& n : near)
          mean += cloud.points.row(n.index) / static_cast<double>(near.size());
        Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
        for (const KdTree::Neighbor& n : near)
          scatter +=
              (cloud.points.row(n.index) - mean).transpose() * (cloud.points.row(n.index) - mean);
        normals.row(i) = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter)
                             .eigenvectors()
                             .col(0)
                             .transpose();
      },
      256);
  return normals;
}

/// @tparam kUnknowns  6, or 7 with the scale
template <int kUnknowns>
void PolishBy(const Cloud& first, const KdTree& tree, const PointsX3& normals, const Cloud& second,
              double limit, double max_color, Similarity3& first_from_second) {
  using Row = Eigen::Matrix<double, kUnknowns, 1>;
  for (int round = 0; round < 40; ++round) {
    Eigen::Matrix<double, kUnknowns, kUnknowns> normal =
        1e-9 * Eigen::Matrix<double, kUnknowns, kUnknowns>::Identity();
    Row right = Row::Zero();
    for (Eigen::Index i = 0; i < second.size(); ++i) {
      const Eigen::Vector3d x =
          first_from_second * Eigen::Vector3d(second.points.row(i).transpose());
      const KdTree::Neighbor n = tree.Nearest(x);
      if (n.squared_distance > limit * limit ||
          (first.colors.row(n.index) - second.colors.row(i)).norm() > max_color)
        continue;
      const Eigen::Vector3d m = normals.row(n.index).transpose();
      const double off = m.dot(x - first.points.row(n.index).transpose());
      const double weight =
          1 / (1 + std::pow(off / (CloudPolishTuning::kRobust * limit), 2));  // Cauchy
      Row row;
      row.template head<6>() << x.cross(m), m;
      if constexpr (kUnknowns == 7) row(6) = x.dot(m);
      normal += weight * row * row.transpose();
      right -= weight * off * row;
    }
    const Row step = normal.ldlt().solve(right);
    const Eigen::Vector3d turn = step.template head<3>();
    const Eigen::Matrix3d rotation =
        turn.norm() > 0 ? Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix()
                        : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
    first_from_second.rotation = rotation * first_from_second.rotation;
    if constexpr (kUnknowns == 7) {
      first_from_second.scale *= 1 + step(6);
      first_from_second.translation *= 1 + step(6);
    }
    first_from_second.translation =
        rotation * first_from_second.translation + step.template segment<3>(3);
    if (step.norm() < 1e-9) break;
  }
}

}  // namespace

Cloud Decimated(const Scene& scene, int count) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const SparsePoint& point : scene.points) values.push_back(point.position[k]);
    middle[k] = UpperMedian(std::move(values));
  }
  std::vector<double> reach;
  for (const SparsePoint& point : scene.points) reach.push_back((point.position - middle).norm());
  const double limit = 1.3 * QuantileAbove(reach, 0.98);
  std::vector<std::size_t> good;
  for (std::size_t i = 0; i < reach.size(); ++i)
    if (reach[i] <= limit) good.push_back(i);
  const auto wanted = std::min<std::size_t>(good.size(), static_cast<std::size_t>(count));
  Cloud cloud{PointsX3(static_cast<Eigen::Index>(wanted), 3),
              PointsX3(static_cast<Eigen::Index>(wanted), 3)};
  for (std::size_t k = 0; k < wanted; ++k) {
    const SparsePoint& point = scene.points[good[k * good.size() / wanted]];
    const Eigen::Vector3d color = point.color.cast<double>() + Eigen::Vector3d::Constant(8);
    cloud.points.row(k) = point.position.transpose();
    cloud.colors.row(k) = color.transpose() / color.sum();
  }
  return cloud;
}

double Spread(const PointsX3& points) {
  return std::sqrt((points.rowwise() - points.colwise().mean()).rowwise().squaredNorm().mean());
}

double Spacing(const Cloud& cloud, const KdTree& tree) {
  std::vector<double> distances;
  for (Eigen::Index i = 0; i < cloud.size(); ++i)
    distances.push_back(tree.Nearest(cloud.points.row(i).transpose(), 2).back().squared_distance);
  return std::sqrt(UpperMedian(std::move(distances)));
}

Eigen::Matrix3d Turn(int i, int count) {
  constexpr double kPhi = 1.4142135623730951, kPsi = 1.533751168755204288118041,
                   kTwoPi = 6.283185307179586;
  const double s = i + 0.5, t = s / count, r = std::sqrt(t), q = std::sqrt(1 - t),
               a = kTwoPi * s / kPhi, b = kTwoPi * s / kPsi;
  return Eigen::Quaterniond(q * std::cos(b), r * std::sin(a), r * std::cos(a), q * std::sin(b))
      .normalized()
      .toRotationMatrix();
}

std::pair<double, double> Agreement(const Cloud& first, const KdTree& tree, const Cloud& second,
                                    const Similarity3& first_from_second, double limit,
                                    double max_color) {
  int agreeing = 0;
  double sum = 0;
  for (Eigen::Index i = 0; i < second.size(); ++i) {
    const KdTree::Neighbor n =
        tree.Nearest(first_from_second * Eigen::Vector3d(second.points.row(i).transpose()));
    if (n.squared_distance > limit * limit ||
        (first.colors.row(n.index) - second.colors.row(i)).norm() > max_color)
      continue;
    ++agreeing;
    sum += n.squared_distance;
  }
  return {static_cast<double>(agreeing) / static_cast<double>(second.size()),
          agreeing > 0 ? std::sqrt(sum / agreeing) : 0};
}

void Polish(const Cloud& first, const KdTree& tree, const Cloud& second, double limit,
            double max_color, bool with_scale, Similarity3& first_from_second) {
  const PointsX3 normals = PlaneNormals(first, tree);
  if (with_scale)
    PolishBy<7>(first, tree, normals, second, limit, max_color, first_from_second);
  else
    PolishBy<6>(first, tree, normals, second, limit, max_color, first_from_second);
}

double AngleBetween(const Similarity3& a, const Similarity3& b) {
  return std::acos(std::clamp(((a.rotation.transpose() * b.rotation).trace() - 1) / 2, -1.0, 1.0));
}

}  // namespace keypose::reconstruct
