// A minimal DNG for tests: the mosaic of a camera whose colours are those of sRGB in linear light.
#pragma once

#include <array>
#include <filesystem>

#include "core/values/image.h"

namespace keypose {

struct DngOptions {
  std::array<double, 3> neutral = {1, 1, 1};  ///< what the sensor gives for white under this light
  int orientation = 1;                        ///< EXIF
};

/// One strip of 16 bits, RGGB, no compression, black 0, white 65535.
/// @param linear  RGB in [0, 1], the scene under white light; even width and height
/// Source: Adobe, Digital Negative Specification 1.4.
void WriteDng(const std::filesystem::path& file, const ImageF& linear, const DngOptions& options);

}  // namespace keypose
