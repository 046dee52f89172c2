// What the readers of rig calibrations share: rotations, sizes and lenses that are checked.
#pragma once

#include <Eigen/Geometry>
#include <string>

#include "core/camera.h"

namespace keypose {

/// A rotation that is one to 1e-2, made exact.
/// @param where  file and camera, for the message
/// @throws InputError  it is none
Eigen::Quaterniond ExactRotation(const Eigen::Matrix3d& r, const std::string& where);

/// @throws InputError  a lens that no camera has, or a place that is not finite
void RequireUsable(const View& view, const std::string& where);

/// A picture's width or height, rounded; a number beyond all pictures stays beyond them.
int SideOf(double pixels);

}  // namespace keypose
