// The poses of a whole take made calm in time, after each frame was fitted by itself.
#pragma once

#include <vector>

#include "motion/tracking/motion_noise.h"
#include "motion/tracking/pose_prior.h"

namespace keypose::motion {

/// First guesses; three times as much changes nothing on the generated performances with seeds 11,
/// 101 and 102, a third nothing with seed 11.
struct CalmTuning {
  /// [rad] that a number may leave its fit by, where no outline holds it; a standard deviation
  KEYPOSE_TUNED(double, kHoldTurn, 0.3);
  KEYPOSE_TUNED(double, kHoldMove, 0.1);  ///< [m] of the root, the same
};

struct FittedFrame {
  BodyPose pose;        ///< with numbers 3 to 5 zero
  PoseSystem evidence;  ///< FrameEvidence: what the frame tells, linearised at `pose`
};

struct CalmedTake {
  std::vector<BodyPose> poses;  ///< with numbers 3 to 5 zero
  double noise = 0;             ///< standard deviation of the fits over what their evidence claims
  DofVector jerks = DofVector::Zero();  ///< variance of each number's jerks
  int rounds = 0;
};

/// The most probable poses of all frames together: each frame's evidence, and accelerations that
/// change little. How much they change, and how much of the fits is noise, is told by the take
/// itself, number by number (FindMotionNoise); a few changes may be large, so that hits and stops
/// stay. What a frame does not tell comes from its neighbours.
///
/// @param strength  factor on the noise's standard deviation, > 0; 1: as the take tells it
/// @return the same poses when there are fewer than kLeastFrames
/// Cost: up to 12 factors of a band, 0.9 million multiplications and 60 kB a frame each.
/// Same bits for any thread count.
CalmedTake CalmTake(const std::vector<FittedFrame>& frames, double strength);

}  // namespace keypose::motion
