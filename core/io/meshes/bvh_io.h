// Reads and writes motions as BVH files (Biovision hierarchy).
#pragma once

#include <filesystem>
#include <string>

#include "core/values/motion_clip.h"

namespace keypose {

/// @param name  of the file, for messages
/// @throws InputError  not a BVH file, truncated, an unknown channel, a number that is not finite;
/// names the line
MotionClip ParseBvh(const std::string& text, const std::string& name);
MotionClip ReadBvh(const std::filesystem::path& path);

/// Numbers have six decimals.
std::string BvhText(const MotionClip& clip);
/// @throws DiskError
void WriteBvh(const std::filesystem::path& path, const MotionClip& clip);

}  // namespace keypose
