// Reads and writes motions as BVH files (Biovision hierarchy).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/values/motion_clip.h"

namespace keypose {

/// Reads what programs of today write: UTF-8 or UTF-16, any case, braces on the line or on their
/// own, `Frames:40`, names with spaces, comments (# and //), joints with any channels in any order,
/// several roots, uniform scale channels (which are put into offsets and positions). A joint whose
/// OFFSET is zero, and whose place stands in its position channels, gets that of the first frame as
/// its offset.
/// @param name  of the file, for messages
/// @param notes  what a person should know, a sentence each: one frame more or less than the file
/// says, a frame that lasts over a second, turns that may be radians
/// @throws InputError  a clip of another kind (named), not a BVH file, truncated, an unknown
/// channel, a number that is not finite or has a decimal comma, two or more frames off, uneven
/// scale; names the line
MotionClip ParseBvh(const std::string& text, const std::string& name,
                    std::vector<std::string>* notes = nullptr);
MotionClip ReadBvh(const std::filesystem::path& path, std::vector<std::string>* notes = nullptr);

/// Numbers have six decimals.
std::string BvhText(const MotionClip& clip);
/// @throws DiskError
void WriteBvh(const std::filesystem::path& path, const MotionClip& clip);

}  // namespace keypose
