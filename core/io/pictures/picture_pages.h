// Files that hold several pictures: animated PNG and WebP, TIFF with pages.
#pragma once

#include <string_view>

namespace keypose {

/// @param bytes  the file's first bytes, 21 or more
bool IsAnimatedWebp(std::string_view bytes);

/// The pictures of an animated PNG; 1 of any other.
/// @param bytes  the file's first bytes, up to where its first picture's data begin
int PngFrames(std::string_view bytes);

}  // namespace keypose
