// A generated theropod: an armature as large as the largest of the paper, the computer skeleton
// that does not quite match it, and a walk.
#pragma once

#include "armature/description/armature.h"
#include "core/values/motion_clip.h"

namespace keypose::armature {

/// 74 sensors: a rig of three slides and three joints, trunk and neck, tail, two legs, two arms.
/// 0.9 m from snout to tail, z up, the snout towards +y, its unit a metre. In its zero position
/// spine and legs are straight and at right angles.
/// Source: Knep et al., CHI 1995, for the number of sensors, the size and the zero position.
Armature MakeTheropod();

/// Six chains: neck and tail to be matched, legs and arms joint on joint.
ChainPlan MakeTheropodChains(const Armature& theropod);

/// The computer skeleton: joints that turn about three axes, of which neck and tail have fewer than
/// the armature, at other places. One frame, the zero position.
MotionClip MakeTheropodSkeleton();

/// A walk on the spot, two steps in 1.2 s, in which all joints move.
/// @return a value for each of the theropod's joints, as ForwardKinematics takes them
std::vector<double> TheropodWalk(const Armature& theropod, double time_s);

/// A motion for any armature: the walk, if its joints are the theropod's; else each joint swings by
/// 0.3 rad (slides by 0.01), each a little later than the one before.
std::vector<double> ExampleMotion(const Armature& armature, double time_s);

}  // namespace keypose::armature
