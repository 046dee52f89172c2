// What is known of a pose without pictures: limits of joints, calm in time, and parts that do not
// pass through each other.
#pragma once

#include <vector>

#include "core/values/tuned.h"
#include "motion/body/body_pose.h"

namespace keypose::motion {

using DofMatrix = Eigen::Matrix<double, kDofs, kDofs>;

/// A sum of squares, linearised: cost(q + d) = cost + 2 gradient^T d + d^T matrix d.
struct PoseSystem {
  DofMatrix matrix = DofMatrix::Zero();
  DofVector gradient = DofVector::Zero();
  double cost = 0;
  PoseSystem& operator+=(const PoseSystem& other);
};

/// Found on the generated performance with seeds 101 and 102.
struct PriorTuning {
  KEYPOSE_TUNED(double, kLimit, 0.03);       ///< [rad] beyond a limit, a standard deviation
  KEYPOSE_TUNED(double, kOverlap, 0.003);    ///< [m] of overlap of two parts, the same
  KEYPOSE_TUNED(double, kTurnChange, 0.12);  ///< [rad/frame^2] of change of a joint's speed
  KEYPOSE_TUNED(double, kMoveChange, 0.03);  ///< [m/frame^2] of change of the root's speed
  KEYPOSE_TUNED(double, kTurn, 0.6);         ///< [rad/frame] of a joint
  KEYPOSE_TUNED(double, kRest, 2.5);         ///< [rad] from the rest pose
};

/// Pulls each number to a mean.
struct QuadraticPrior {
  DofVector mean = DofVector::Zero();
  DofVector weight = DofVector::Zero();  ///< 1 / variance
};
/// From the rest pose; only the joints.
QuadraticPrior RestPrior();
/// From the last two poses of a sequence: constant speed, and little speed.
/// @param before, before_that  in the chart of the pose that is looked for
std::vector<QuadraticPrior> CalmPriors(const DofVector& before, const DofVector& before_that);

void AddQuadratic(const QuadraticPrior& prior, const DofVector& q, PoseSystem* system);
/// Squares of how far joints are beyond their limits.
void AddLimits(const DofVector& q, PoseSystem* system);
/// Squares of overlaps of capsules inside of segments that are not neighbours.
void AddOverlaps(const PosedBody& body, const BodyShape& shape, PoseSystem* system);

/// Moves the numbers of a pose into another chart of the root's rotation.
DofVector InChart(const BodyPose& pose, const Eigen::Quaterniond& chart);

}  // namespace keypose::motion
