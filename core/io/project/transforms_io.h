// Reads transforms.json, as nerfstudio, instant-ngp and the programs around them write cameras.
#pragma once

#include <filesystem>
#include <vector>

#include "core/values/lens.h"

namespace keypose {

/// Matrices are camera to world, 4 x 4 or 3 x 4, with x right, y up and z backwards. A frame's own
/// numbers count before the file's:
/// - focal length: fl_x, fl_y, camera_angle_x, camera_angle_y [rad], x_fov, y_fov [deg]; w, h, cx,
/// cy
/// - camera_model: SIMPLE_PINHOLE, PINHOLE, perspective, OPENCV and the like: k1 to k4 (all radial,
/// as
///   nerfstudio has it), p1, p2; OPENCV_FISHEYE, fisheye, is_fisheye: k1 to k4; FULL_OPENCV: k1 to
///   k6
/// - file_path: with either slash; the view's name is the file's, with as many folders as tell
/// equal
///   names apart
/// What tells of the world alone (applied_transform, scale, aabb_scale, ...) is not needed:
/// matrices already have it. Masks, depths, point clouds and lists of splits beside the cameras are
/// not read.
/// @return views; width and height 0 where they are not given; fx, fy negative in units of the
/// width where there is an angle alone
/// @throws InputError  damaged, no focal length, a matrix that is no rigid motion, two frames of a
/// file, another model or convention (EQUIRECTANGULAR, FISHEYE624, ftheta, latlong, from_na, ...):
/// names file, frame, model
std::vector<LensView> ReadTransforms(const std::filesystem::path& path);

}  // namespace keypose
