// A pose in which every degree of freedom differs from zero.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "motion/body/body_pose.h"

namespace keypose::motion {

// A pose in which no number is zero, within the limits, the same on every machine.
inline BodyPose SomePose(int seed) {
  BodyPose pose;
  for (int i = 0; i < kDofs; ++i) {
    const double wave = std::sin(12.9898 * (i + 1) + 78.233 * (seed + 1));
    const DofModel& dof = Dofs()[i];
    pose.q[i] = dof.low == dof.high ? 0.7 * wave
                                    : (dof.low + dof.high) / 2 + 0.45 * wave * (dof.high - dof.low);
  }
  pose.root_chart = Eigen::Quaterniond(
      Eigen::AngleAxisd(1.1 * seed, Eigen::Vector3d(0.2, 0.3, 0.9).normalized()));
  return pose;
}

}  // namespace keypose::motion
