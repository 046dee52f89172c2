// Reads cameras that are known in advance, from a rig, a robot or another program.
#pragma once

#include <filesystem>
#include <vector>

#include "core/values/camera.h"

namespace keypose {

/// Reads a COLMAP model (folder, binary or text) or a transforms.json as NeRF programs write it, by
/// its name or that of its folder. The matrices are camera to world, with x right, y up and z
/// backwards. The focal length is fl_x, fl_y or camera_angle_x. These and k1, k2, p1, p2, cx, cy,
/// w, h may be given for the whole file or for a frame. The name of a view is the file name in its
/// file_path, without folders.
/// @return views sorted by name; width, height, cx, cy are 0 where the file does not give them
/// @throws InputError  of neither kind, damaged, no camera, a repeated name, or a matrix that is
/// not a rigid motion; names file and frame
std::vector<View> ReadPoses(const std::filesystem::path& path);

}  // namespace keypose
