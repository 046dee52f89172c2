// Pictures in linear light, and smoothing of them.
#pragma once

#include "core/image.h"

namespace keypose::composite {

/// @param srgb  any number of channels
ImageF LinearOf(const Image8& srgb);
/// Rounded; values outside [0, 1] are clamped.
Image8 SrgbOf(const ImageF& linear);
/// Stored values, 0 to 255, without rounding.
ImageF LevelsOf(const ImageF& linear);

/// A Gaussian blur; the border is repeated. sigma_px <= 0: a copy.
/// Same bits for any thread count.
ImageF Blurred(const ImageF& image, double sigma_px);

}  // namespace keypose::composite
