// Bone lengths and girths of the actor, from one or several frames whose poses are nearly known.
#pragma once

#include <vector>

#include "core/values/progress.h"
#include "motion/tracking/pose_solver.h"

namespace keypose::motion {

/// Found on the generated performance with seeds 101 and 102 and on the dome.
struct ActorTuning {
  /// weight of the outlines: a template's errors are alike over much longer ways than a mask's
  KEYPOSE_TUNED(double, kTrust, 0.03);
  KEYPOSE_TUNED(double, kLength, 0.05);       ///< share of a bone that it differs from proportion
  KEYPOSE_TUNED(double, kGirth, 0.03);        ///< [m] of a mean radius from proportion
  KEYPOSE_TUNED(double, kOneSided, 0.004);    ///< [m] of a limb's surface beside its bone
  KEYPOSE_TUNED(double, kWave, 0.012);        ///< [m] of a radius around the segment
  KEYPOSE_TUNED(double, kBend, 0.008);        ///< [m] of second differences along the segment
  KEYPOSE_TUNED(double, kSides, 0.02);        ///< [m] of radii between left and right
  KEYPOSE_TUNED(double, kSideLength, 0.015);  ///< share of a bone between left and right
  KEYPOSE_TUNED(double, kSettled, 3e-4);      ///< [m] of change of lengths in a round: it ends
};

struct ActorFrame {
  std::vector<Silhouette> silhouettes;
  BodyPose pose;
  std::vector<QuadraticPrior> priors;
};

struct ActorOptions {
  int rounds = 8;
  double reach = OutlineTuning::kReach;  ///< [px]
  double first_reach = 20;               ///< [px] in the first round
  bool waves = true;                     ///< false: only lengths and mean radii may change freely
};

/// Gauss-Newton over the shape and all frames' poses together. Proportions and smooth girths are
/// preferred where outlines say little; size as a whole is free.
/// @return the sum of all squares, outlines and preferences, before the last step: fits of one
/// frame from different starts are compared by it Cost: frames x views rows of about 45 numbers,
/// and one dense factor of 801 + 38 frames unknowns a round. Same bits for any thread count.
double FitActor(std::vector<ActorFrame>* frames, BodyShape* shape, const ActorOptions& options,
                Progress* progress = nullptr);

}  // namespace keypose::motion
