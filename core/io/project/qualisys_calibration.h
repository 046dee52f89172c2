// Reads the calibration that Qualisys exports (.qca.txt).
#pragma once

#include <string>

#include "core/io/project/rig_parts.h"

namespace keypose {

/// Adds the cameras of the XML text, its millimetres as metres. Lengths on the sensor are in 64ths
/// of a pixel. Bounds name the last pixel, or its last 64th: a picture of 1088 pixels ends at 1087,
/// at 69568 or at 69631. Where the camera filmed only a window of its sensor (`fov_video`), the
/// view is that of the window.
/// @param file  its name, for messages
/// @throws InputError  a number that is missing or none, a lens that no camera has, a rotation that
/// is none; names file and camera
void AddQualisys(const std::string& text, const std::string& file, RigCalibration* rig);

}  // namespace keypose
