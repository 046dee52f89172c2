// Cameras that are known beforehand: from a rig, a robot, another program.
#pragma once

#include <filesystem>
#include <vector>

#include "core/camera.h"

namespace keypose {

/// Reads a COLMAP model (folder, binary or text) or a transforms.json as NeRF programs write it
/// (camera to world, x right, y up, z backwards; focal length as fl_x, fl_y or camera_angle_x; k1,
/// k2, p1, p2, cx, cy, w, h; each for the file or for a frame). A frame's name is its file_path,
/// without what leads to it.
/// @return views sorted by name; width, height, cx, cy are 0 where the file does not say
/// @throws InputError  neither, damaged, no camera, a name twice, or a matrix that is no rigid
/// motion; names file and frame
std::vector<View> ReadPoses(const std::filesystem::path& path);

}  // namespace keypose
