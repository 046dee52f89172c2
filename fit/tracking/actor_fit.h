// Bone lengths and girths of the actor, from one or several frames whose poses are nearly known.
#pragma once

#include <vector>

#include "core/progress.h"
#include "fit/tracking/pose_solver.h"

namespace keypose::fit {

/// Found on the generated performance with seeds 101 and 102 and on the dome.
struct ActorTuning {
  KEYPOSE_TUNED(double, kLength, 0.05);       ///< share of a bone that it differs from proportion
  KEYPOSE_TUNED(double, kGirth, 0.03);        ///< [m] of a mean radius from proportion
  KEYPOSE_TUNED(double, kWave, 0.012);        ///< [m] of a radius around the segment
  KEYPOSE_TUNED(double, kBend, 0.008);        ///< [m] of second differences along the segment
  KEYPOSE_TUNED(double, kSides, 0.02);        ///< [m] between left and right
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
/// @return robust cost of the silhouettes per measurement [px^2]
/// Cost: frames x views rows of about 45 numbers, and one dense factor of 801 + 38 frames unknowns a
/// round. Same bits for any thread count.
double FitActor(std::vector<ActorFrame>* frames, BodyShape* shape, const ActorOptions& options,
                Progress* progress = nullptr);

}  // namespace keypose::fit
