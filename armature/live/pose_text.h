// A puppet's pose as a line of JSON, and its motion as a clip.
#pragma once

#include <string>
#include <vector>

#include "armature/live/posed_puppet.h"
#include "core/values/motion_clip.h"

namespace keypose::armature {

/// What a line says besides the pose.
struct PoseLine {
  double time_s = 0;     ///< since the stream began
  long number = 0;       ///< of the update
  bool fresh = true;     ///< the controller answered
  double latency_s = 0;  ///< from the request to the controller to the posed mesh
};

/// {"pose": number, "time", "fresh", "latency_ms", "matched": chains that were matched again,
/// "joints": {"NAME": [x, y, z, qw, qx, qy, qz], ...}, "gaps": {"CHAIN": [near, far], ...}}. A
/// joint's place, and the turn of its bone from rest (LeadingBones); gaps only of chains that
/// cannot meet both anchors.
std::string PoseJson(const Skeleton& skeleton, const PuppetMatcher& matcher, const PoseLine& line);

/// Poses as a motion clip with z up. A joint from which several bones lead away turns with its
/// leading bone; the others get a joint of their own at the same place, named "NAME_turn".
/// @param poses  one a frame, at least one
MotionClip SkeletonClip(const Skeleton& skeleton, const std::vector<SkeletonPose>& poses,
                        double fps);

}  // namespace keypose::armature
