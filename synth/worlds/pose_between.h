// Poses on the way from one pose to another.
#pragma once

#include "synth/worlds/pose.h"

namespace keypose::synth {

/// The pose a share of the way from `a` to `b`: angles and ratios of deformations that both have go
/// straight from one to the other, those that only one has fade out or in. At 0 it is `a`, at 1
/// `b`.
/// @param share  in [0,1]
Pose PoseBetween(const Pose& a, const Pose& b, double share);

}  // namespace keypose::synth
