#include "core/numbers/rotations.h"

#include <algorithm>
#include <cmath>

#include "core/values/tuned.h"

namespace keypose {

namespace {

// Chosen on bends and twists with known answers and on real keys (docs/results/interpolation.md,
// docs/algorithms/interpolate.md); sensitivity: docs/results/sensitivity.md.
struct RotationsTuning {
  // rad: below it, a rotation vector amplifies noise less than twofold
  KEYPOSE_TUNED(double, kTrustedTurn, 3.5);
  KEYPOSE_TUNED(double, kSlack, 0.3);    // rad: beyond twice the difference of two rotations
  KEYPOSE_TUNED(double, kDamping, 0.5);  // sin x / x that halves the step across the axis
};

constexpr double kWholeTurn = 6.283185307179586;
constexpr double kAxisless = 1e-6;  // rotations below this have no usable axis

}  // namespace

Eigen::Vector3d LogOf(const Eigen::Matrix3d& rotation) {
  return LogOf(Eigen::Quaterniond(rotation).normalized());
}

Eigen::Vector3d LogOf(const Eigen::Quaterniond& q) {
  const double sine = q.vec().norm();
  if (sine < 1e-12) return std::copysign(2.0, q.w()) * q.vec();
  return (2 * std::atan2(std::copysign(sine, q.w()), std::abs(q.w())) / sine) * q.vec();
}

Eigen::Quaterniond QuaternionOf(const Eigen::Vector3d& turn) {
  const double half = 0.5 * turn.norm();
  const double scale = half > 1e-150 ? 0.5 * std::sin(half) / half : 0.5;
  return {std::cos(half), scale * turn[0], scale * turn[1], scale * turn[2]};
}

Eigen::Matrix3d ExpOf(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  if (angle == 0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

double RotationDifference(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  const double cosine = a.dot(b);
  return std::max(0.0, 1 - cosine * cosine);
}

double AngleOfDifference(double sine2) { return 2 * std::asin(std::min(1.0, std::sqrt(sine2))); }

Eigen::Vector3d TurnAfter(const Eigen::Vector3d& before, const Eigen::Quaterniond& before_rotation,
                          const Eigen::Quaterniond& rotation) {
  const Eigen::Vector3d shortest = LogOf(rotation);
  const double angle = shortest.norm(), length = before.norm();
  Eigen::Vector3d nearest = shortest;
  if (angle > kAxisless) {
    const Eigen::Vector3d axis = shortest / angle;
    nearest = (angle + kWholeTurn * std::round((before.dot(axis) - angle) / kWholeTurn)) * axis;
  }
  if (length < kAxisless) return nearest;
  if (length < RotationsTuning::kTrustedTurn && nearest.norm() < RotationsTuning::kTrustedTurn &&
      (nearest - before).norm() <=
          2 * AngleOfDifference(RotationDifference(before_rotation, rotation)) +
              RotationsTuning::kSlack)
    return nearest;
  // Towards whole turns the axis of a rotation vector becomes uncertain. From the given
  // vector, the angle takes the full step and the axis as much as is certain: Newton's step for
  // exp(turn) = rotation, damped across the axis where its derivative s = sin x / x (x half the
  // angle) vanishes.
  const Eigen::Vector3d axis = before / length, step = LogOf(QuaternionOf(-before) * rotation),
                        across = step - step.dot(axis) * axis;
  const double x = 0.5 * length, s = std::sin(x) / x,
               damping = s * s / (s * s + RotationsTuning::kDamping * RotationsTuning::kDamping);
  const double x_cot_x = std::abs(s) > 1e-9 ? std::cos(x) / s : 0.0;
  return before + step.dot(axis) * axis + damping * (x_cot_x * across + x * axis.cross(across));
}

}  // namespace keypose
