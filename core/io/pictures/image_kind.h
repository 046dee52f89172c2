// Finds the image format of a file, and whether the file is complete, from its bytes alone. This
// happens before any decoder reads the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace keypose {

/// The largest number of pixels that is accepted: 16384 x 16384, more than any camera on the market
/// has.
inline constexpr std::int64_t kMostPixels = std::int64_t{1} << 28;

/// "jpeg", "png", "tiff" or "heif", judged by the first bytes of a file; "" for anything else. The
/// file's name does not matter.
/// @param head  the first 4096 bytes, or all of a shorter file
std::string ImageKindOf(std::string_view head);

/// What a file is that ImageKindOf does not know, for messages: "a WebP picture", "a web page"; ""
/// if that is not known either.
/// @param head  its first bytes
std::string OtherKindOf(std::string_view head);

/// Whether a JPEG has its end marker (not only that of an embedded thumbnail), or a PNG its last
/// chunk. True for other formats.
/// @param bytes  the whole file
bool IsWholeImage(std::string_view bytes, const std::string& kind);

/// What is wrong with a file that a person gives as a photograph, as words that follow its name:
/// "is a web page, whatever its name says; save it as JPEG or PNG". "" if its first bytes and its
/// end are those of a picture that is read; that can be told before it is decoded.
/// @param bytes  the whole file
std::string PhotographFault(std::string_view bytes);

/// The largest number of pixels that any picture in a HEIF file claims. The decoder allocates
/// memory for them before it reports their number, so this is checked first.
/// @param bytes  the whole file
std::int64_t ClaimedHeifPixels(std::string_view bytes);

}  // namespace keypose
