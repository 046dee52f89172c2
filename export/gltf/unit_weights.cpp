#include "export/gltf/unit_weights.h"

#include <Eigen/Dense>
#include <algorithm>
#include <utility>
#include <vector>

#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

constexpr double kSmallestCosine = 1e-3;
constexpr double kSmallestWay = 1e-9;
constexpr int kMostSteps = 2000;

/// Directions from the first picture to the others, in the space of weights, of unit length.
/// Without those that have its weights.
Eigen::MatrixXd DirectionsFromFirst(const Eigen::MatrixXd& weights) {
  const Eigen::MatrixXd ways = weights.rowwise() - weights.row(0);
  std::vector<int> others;
  for (int p = 0; p < ways.rows(); ++p)
    if (ways.row(p).norm() > kSmallestWay) others.push_back(p);
  return ways(others, Eigen::all).rowwise().normalized();
}

/// The vector with the smallest largest angle to all directions: the point of their convex hull
/// that is nearest to the origin. Source: Gilbert, SIAM J. Control 1966.
Eigen::VectorXd MiddleOf(const Eigen::MatrixXd& directions) {
  Eigen::VectorXd point = directions.colwise().mean();
  for (int step = 0; step < kMostSteps; ++step) {
    Eigen::Index farthest = 0;
    const double least = (directions * point).minCoeff(&farthest);
    const double gap = point.squaredNorm() - least;
    if (gap < 1e-6 * point.squaredNorm()) break;
    const Eigen::VectorXd way = directions.row(farthest).transpose() - point;
    point += std::min(1.0, gap / way.squaredNorm()) * way;
  }
  return point.normalized();
}

/// @param from_old  new weights of differences of old ones
/// @param origin    old weights whose new weights are 0
MorphBasis InNewWeights(const MorphBasis& basis, const Eigen::MatrixXd& from_old,
                        const Eigen::VectorXd& origin) {
  const Eigen::MatrixXd to_old = from_old.inverse();
  MorphBasis out{basis.base, {}, basis.weights};
  out.weights.rowwise() -= origin.transpose();
  out.weights = (out.weights * from_old.transpose()).eval();
  const Eigen::RowVectorXd top = out.weights.colwise().maxCoeff();
  for (int k = 0; k < SizeOf(basis.targets); ++k) {
    out.base += origin(k) * basis.targets[k];
    out.targets.emplace_back(PointsX3::Zero(basis.base.rows(), 3));
    const double scale = top(k) > 0 ? top(k) : 1;
    for (int j = 0; j < SizeOf(basis.targets); ++j)
      out.targets[k] += scale * to_old(j, k) * basis.targets[j];
    out.weights.col(k) /= scale;
  }
  out.weights = out.weights.cwiseMax(0).cwiseMin(1).eval();
  return out;
}

/// New weights in which no picture has one below that of the first picture: one along the middle of
/// all directions, and others turned towards it until they are positive. Empty if the directions
/// do not lie within a half-space.
Eigen::MatrixXd ConeWeights(const Eigen::MatrixXd& weights) {
  const Eigen::MatrixXd directions = DirectionsFromFirst(weights);
  if (directions.rows() == 0) return {};
  const Eigen::VectorXd middle = MiddleOf(directions);
  const Eigen::VectorXd along = directions * middle;
  if (!(along.minCoeff() > kSmallestCosine)) return {};
  Eigen::MatrixXd rows = Eigen::MatrixXd(middle.householderQr().householderQ()).transpose();
  rows.row(0) = middle.transpose();
  for (Eigen::Index k = 1; k < rows.rows(); ++k) {
    const Eigen::VectorXd across = directions * rows.row(k).transpose();
    rows.row(k) -= across.cwiseQuotient(along).minCoeff() * middle.transpose();
  }
  return rows;
}

double LargestTarget(const MorphBasis& basis) {
  double largest = 0;
  for (const PointsX3& target : basis.targets)
    largest = std::max(largest, target.rowwise().norm().maxCoeff());
  return largest;
}

bool AreUnit(const Eigen::MatrixXd& weights) {
  return weights.row(0).isZero(0) && weights.minCoeff() >= 0 && weights.maxCoeff() <= 1;
}

}  // namespace

bool MakeUnitWeights(MorphBasis& basis, double largest_target) {
  if (basis.targets.empty() || AreUnit(basis.weights)) return true;
  const Eigen::MatrixXd cone = ConeWeights(basis.weights);
  if (cone.size() > 0) {
    MorphBasis from_first = InNewWeights(basis, cone, basis.weights.row(0));
    if (LargestTarget(from_first) <= largest_target) {
      basis = std::move(from_first);
      return true;
    }
  }
  const Eigen::Index count = basis.weights.cols();
  const Eigen::VectorXd corner = basis.weights.colwise().minCoeff();
  basis = InNewWeights(basis, Eigen::MatrixXd::Identity(count, count), corner);
  return false;
}

}  // namespace keypose::exporting
