// Pictures in linear light, and smoothing of them.
#pragma once

#include "core/values/image.h"

namespace keypose::composite {

/// @param srgb  any number of channels
ImageF LinearOf(const Image8& srgb);
/// @param levels  stored values, 0 to 255, with fractions where a file has more than 8 bits
ImageF LinearOfLevels(const ImageF& levels);
/// Rounded; values outside [0, 1] are clamped.
Image8 SrgbOf(const ImageF& linear);
/// Stored values, 0 to 255, without rounding.
ImageF LevelsOf(const ImageF& linear);
/// Stored values, 0 to 255, as whole levels.
Image8 Rounded(const ImageF& levels);

/// A Gaussian blur; the border is repeated. sigma_px <= 0: a copy.
/// Same bits for any thread count.
ImageF Blurred(const ImageF& image, double sigma_px);

}  // namespace keypose::composite
