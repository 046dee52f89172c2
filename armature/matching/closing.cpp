#include "armature/matching/closing.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/values/angles.h"
#include "core/values/size_of.h"

namespace keypose::armature {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// Relative to the chain's length. Nearer to the limits a chain counts as straight.
constexpr double kLimit = 1e-13, kClosed = 1e-14, kAlmostClosed = 3e-13;
constexpr double kLongestClosingTurn = 0.5;  // [rad] of a rod in one step
constexpr int kMostSteps = 60;

/// How far the rods of half angles asin(length * curvature) reach on a circle of that curvature,
/// where the curvature is 1 / diameter.
/// @param longest  its rod takes the longer way round the circle; -1: none does
double ChordOf(const Eigen::VectorXd& lengths, double curvature, int longest) {
  double half = 0;
  for (int i = 0; i < lengths.size(); ++i) {
    const double angle = std::asin(std::min(1.0, lengths[i] * curvature));
    half += i == longest ? kPi - angle : angle;
  }
  return std::sin(half) / curvature;
}

/// The curvature for which the rods reach `distance`.
double CurvatureOf(const Eigen::VectorXd& lengths, double distance, int* longest_way) {
  Eigen::Index longest = 0;
  double none = 0, most = 1 / lengths.maxCoeff(&longest);
  *longest_way = ChordOf(lengths, most, -1) > distance ? static_cast<int>(longest) : -1;
  // With a short way for all rods, less curvature reaches further. With the long way for one of
  // them, more curvature does.
  const bool further_with_less = *longest_way < 0;
  for (int step = 0; step < 200; ++step) {
    const double middle = 0.5 * (none + most);
    const bool too_far = ChordOf(lengths, middle, *longest_way) > distance;
    (too_far == further_with_less ? none : most) = middle;
  }
  return 0.5 * (none + most);
}

Vector3d SumOf(const Eigen::VectorXd& lengths, const Directions& directions) {
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < SizeOf(directions); ++i) sum += lengths[i] * directions[i];
  return sum;
}

/// One step towards a sum that is `missing` away.
void TurnRods(const Eigen::VectorXd& lengths, const Vector3d& missing, Directions& directions) {
  Matrix3d moves = Matrix3d::Zero();
  for (int i = 0; i < SizeOf(directions); ++i)
    moves += lengths[i] * lengths[i] *
             (Matrix3d::Identity() - directions[i] * directions[i].transpose());
  moves.diagonal().array() += 1e-15 * moves.trace();
  Vector3d pull = moves.ldlt().solve(missing);
  const double turn = lengths.maxCoeff() * pull.norm();
  if (turn > kLongestClosingTurn) pull *= kLongestClosingTurn / turn;
  for (int i = 0; i < SizeOf(directions); ++i) {
    Vector3d& u = directions[i];
    u = (u + lengths[i] * (pull - u * u.dot(pull))).normalized();
  }
}

/// The direction across `along` on the given side. Without a side that is upwards, or, for a chain
/// that stands upright, along y: a figure whose mirror plane is x = 0 stays symmetric.
Vector3d AcrossTo(const Vector3d& along, const Vector3d& side) {
  constexpr double kUpright = 0.5;
  const Vector3d given = side - along * along.dot(side);
  if (given.norm() > 1e-9 * side.norm()) return given.normalized();
  const Vector3d up = Vector3d::UnitZ() - along * along.z();
  return up.norm() > kUpright ? up.normalized()
                              : Vector3d(Vector3d::UnitY() - along * along.y()).normalized();
}

}  // namespace

Reach ReachOf(const Eigen::VectorXd& lengths, double distance) {
  const double sum = lengths.sum();
  if (distance >= sum * (1 - kLimit)) return Reach::kTooFar;
  const double nearest = 2 * lengths.maxCoeff() - sum;
  return nearest > 0 && distance <= nearest + kLimit * sum ? Reach::kTooNear : Reach::kReachable;
}

bool CloseChain(const Eigen::VectorXd& lengths, const Vector3d& span, Directions& directions) {
  const double sum = lengths.sum();
  double before = 0;
  for (int step = 0; step < kMostSteps; ++step) {
    const Vector3d missing = span - SumOf(lengths, directions);
    const double off = missing.norm();
    if (!std::isfinite(off)) return false;
    if (off <= kClosed * sum) return true;
    // Where the rods are nearly straight, rounding ends the descent earlier.
    if (step > 5 && off <= kAlmostClosed * sum && off >= 0.5 * before) return true;
    before = off;
    TurnRods(lengths, missing, directions);
  }
  return before <= kAlmostClosed * sum;
}

Directions RodsOnCircle(const Eigen::VectorXd& lengths, const Vector3d& span,
                        const Vector3d& side) {
  const double distance = span.norm();
  const Vector3d along = distance > 0 ? Vector3d(span / distance) : Vector3d::UnitX();
  const Vector3d up = AcrossTo(along, side);
  int longest = -1;
  const double curvature = CurvatureOf(lengths, distance, &longest);
  std::vector<double> headings;
  double heading = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int i = 0; i < lengths.size(); ++i) {
    const double angle = std::asin(std::min(1.0, lengths[i] * curvature));
    const double half = i == longest ? kPi - angle : angle;
    headings.push_back(heading - half);
    heading -= 2 * half;
    sum += lengths[i] * Eigen::Vector2d(std::cos(headings[i]), std::sin(headings[i]));
  }
  const double turn = distance > 0 ? std::atan2(sum.y(), sum.x()) : 0;
  Directions directions;
  for (const double angle : headings)
    directions.push_back(std::cos(angle - turn) * along + std::sin(angle - turn) * up);
  return directions;
}

}  // namespace keypose::armature
