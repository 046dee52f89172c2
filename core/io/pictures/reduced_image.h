// Reads large photographs at a fraction of their size. A JPEG is decoded at that size, in a third
// of the time and a fraction of the memory; masks (grey PNG files) are averaged row by row, other
// pictures when they are decoded.
#pragma once

#include <filesystem>

#include "core/values/image.h"

namespace keypose {

/// The fewest eighths of its size at which a picture's longer side still has `least_px`; 8 for
/// pictures that are smaller.
int EighthsFor(int width, int height, int least_px);

/// The picture at `eighths` of its size: each pixel is the mean of 8 / eighths of the picture's
/// pixels along both axes, so that a place p of the picture is at p * eighths / 8 (pixel centres at
/// .5). The last column and row may cover pixels beyond the picture, which repeat its border.
/// @param eighths  1 to 8
Image8 Reduced(Image8 image, int eighths);

/// ReadImage at `eighths` of the size: its pixels as Reduced gives them, but for the rounding. (A
/// JPEG's means are taken from its cosine terms, which keeps more of the contrast of fine detail.)
/// @param channels  1 (luma) or 3 (RGB)
/// @throws DiskError, InputError  as ReadImage
Image8 ReadReduced(const std::filesystem::path& path, int channels, int eighths);

/// ReadImage, with larger pictures reduced until their longer side has `longer_px`: each pixel is
/// the mean of those nearer to its centre than its neighbours' centres are, weighed by how near. A
/// place p of the picture is at p * the reduced size / the size, along each axis. A JPEG is decoded
/// at the fewest eighths that are half as large again.
/// @param longer_px  1 or more
/// @throws DiskError, InputError  as ReadImage
Image8 ReadReducedTo(const std::filesystem::path& path, int channels, int longer_px);

}  // namespace keypose
