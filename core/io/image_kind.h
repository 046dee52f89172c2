// What kind of picture a file holds, and whether it is all there, told by its bytes alone: before a
// library that decodes pictures sees it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace keypose {

/// Pixels of the largest picture that is read: a square of 16384, more than any camera sold takes.
inline constexpr std::int64_t kMostPixels = std::int64_t{1} << 28;

/// "jpeg", "png", "tiff" or "heif", by the first bytes of a file; "" for all else, whatever its
/// name.
/// @param head  the first 4096 bytes, or all of a shorter file
std::string ImageKindOf(std::string_view head);

/// Whether a JPEG's own end mark is there, not that of a thumbnail within it, or a PNG's last
/// chunk; true for other kinds.
/// @param bytes  the whole file
bool IsWholeImage(std::string_view bytes, const std::string& kind);

/// The most pixels that any picture within a HEIF file claims. Its decoder takes memory for them
/// before it tells anyone.
/// @param bytes  the whole file
std::int64_t ClaimedHeifPixels(std::string_view bytes);

}  // namespace keypose
