// The character lying on its back, so that the camera sees its underside: the second half of a flip
// capture.
#pragma once

#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "synth/worlds/pose.h"

namespace keypose::synth {

struct Lying {
  Pose pose;  ///< the standing pose, followed by a rigid rotation
  /// that rotation: from the standing character's frame to the frame of the table
  Rigid3 table_from_character;
};

/// Lays the character with its back on the table (z = 0), head towards +y, centred on the axis.
/// @param standing  the surface's points in the standing pose
Lying LayDown(const Pose& standing_pose, const PointsX3& standing);

}  // namespace keypose::synth
