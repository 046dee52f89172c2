// Writes PNG images by libpng. For programs that write pictures but read no photographs: they start
// faster without OpenImageIO.
#pragma once

#include <filesystem>

#include "core/values/image.h"

namespace keypose {

/// 1 (grey), 3 (sRGB) or 4 (sRGB and alpha) channels, 8 bit.
/// @throws DiskError  names the path and the reason
void WritePng(const std::filesystem::path& path, const Image8& image);

/// A mask of one channel with one bit a pixel: white above 127. A film has thousands of masks, and
/// one of 8 bits takes many times as long to read.
/// @throws DiskError  names the path and the reason
void WriteMaskPng(const std::filesystem::path& path, const Image8& mask);

/// A mask of one channel with 8 bits a pixel, as programs of all kinds expect it. Takes a quarter
/// of the time of other PNG writers, which look for patterns that masks do not have.
/// @throws DiskError  names the path and the reason
void WriteGreyMaskPng(const std::filesystem::path& path, const Image8& mask);

}  // namespace keypose
