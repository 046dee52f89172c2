// A sequence of poses as a motion clip, for BVH files.
#pragma once

#include <vector>

#include "core/values/motion_clip.h"
#include "motion/body/body_pose.h"

namespace keypose::motion {

/// The poses as a clip of 18 joints, y up, in the unit of the shape.
/// @param clip_from_world  turns the world's up onto y
MotionClip ClipOf(const std::vector<BodyPose>& poses, const BodyShape& shape, double frame_time_s,
                  const Eigen::Quaterniond& clip_from_world);

}  // namespace keypose::motion
