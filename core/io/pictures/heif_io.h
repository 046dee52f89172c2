// Reads the pixels of HEIC photographs by libheif directly: OpenImageIO 2.4 has read beyond them.
#pragma once

#include <filesystem>

#include "core/values/image.h"

namespace keypose {

/// The primary picture as 8-bit sRGB, whatever its colour profile, rotated and mirrored as the container says (irot, imir).
/// @throws InputError  truncated or damaged, or the container claims another size than the picture
/// has; names the file
Image8 ReadHeif(const std::filesystem::path& path);

}  // namespace keypose
