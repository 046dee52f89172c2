// Writes PNG images by libpng. For programs that write pictures but read no photographs: they start
// faster without OpenImageIO.
#pragma once

#include <filesystem>

#include "core/image.h"

namespace keypose {

/// 1 (grey) or 3 (sRGB) channels, 8 bit.
/// @throws DiskError  names the path and the reason
void WritePng(const std::filesystem::path& path, const Image8& image);

}  // namespace keypose
