#include "composite/plan/placement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"

namespace keypose::composite {
namespace {

constexpr int kRounds = 40;
/// Residuals below this share of the diagonal are noise of the two shapes.
constexpr double kLeastScale = 1e-4;

Rigid3 RigidOf(const Similarity3& fit) {
  return {Eigen::Quaterniond(fit.rotation).normalized(), fit.translation};
}

}  // namespace

CommonMotion FindCommonMotion(const PointsX3& a, const PointsX3& b) {
  CommonMotion motion{{}, Eigen::VectorXd::Ones(a.rows())};
  const double least = kLeastScale * BoundingDiagonal(a);
  for (int round = 0; round < kRounds; ++round) {
    const Similarity3 fit = FitSimilarity(a, b, motion.weights, false);
    motion.b_from_a = RigidOf(fit);
    const Eigen::VectorXd squared = (Transformed(fit, a) - b).rowwise().squaredNorm();
    const double scale2 = std::max(UpperMedian(squared), least * least);
    motion.weights = (scale2 / (scale2 + squared.array())).square();
  }
  return motion;
}

PlacementBetween::PlacementBetween(const PointsX3& a_in_world, const PointsX3& b_in_world)
    : a_(a_in_world), b_(b_in_world), motion_(FindCommonMotion(a_in_world, b_in_world)) {
  centroid_ = (a_.transpose() * motion_.weights) / motion_.weights.sum();
}

PointsX3 PlacementBetween::Place(const PointsX3& shape, double scale, double share) const {
  const Rigid3& whole = motion_.b_from_a;
  const Eigen::Quaterniond turn = Eigen::Quaterniond::Identity().slerp(share, whole.rotation);
  const Eigen::Vector3d way = whole * centroid_ - centroid_;
  const Rigid3 from_a{turn, centroid_ + share * way - turn * centroid_};
  const Rigid3 from_b = Compose(from_a, whole.Inverse());
  PointsX3 goal(a_.rows(), 3);
  for (Eigen::Index v = 0; v < a_.rows(); ++v) {
    const Eigen::Vector3d a = a_.row(v), b = b_.row(v);
    goal.row(v) = ((1 - share) * (from_a * a) + share * (from_b * b)).transpose();
  }
  const PointsX3 scaled = scale * shape;
  return Transformed(FitSimilarity(scaled, goal, motion_.weights, false), scaled);
}

}  // namespace keypose::composite
