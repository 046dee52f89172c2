// Brightness of a picture at halved resolutions.
#pragma once

#include <vector>

#include "core/values/image.h"

namespace keypose::fit {

/// One channel, 0..255: luma of an sRGB picture; level 0 has its size, each next one half of it.
using GreyPyramid = std::vector<ImageF>;

/// @param levels  at least 1; fewer are made when a side gets below 8 pixels
GreyPyramid MakeGreyPyramid(const Image8& picture, int levels);

/// Bilinear value; coordinates outside are clamped. Pixel centres lie at whole numbers.
float SampleGrey(const ImageF& image, double x, double y);

}  // namespace keypose::fit
