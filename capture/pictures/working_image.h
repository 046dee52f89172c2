// Photographs and masks at working size.
#pragma once

#include "core/values/image.h"

namespace keypose::capture {

/// The image reduced so that its longer side is `working_px` (never enlarged).
Image8 WorkingImage(const Image8& image, int working_px);

/// A mask that was made at `eighths` of a picture's size, at the picture's size: 255 or 0, its
/// border smooth.
Image8 EnlargedMask(const Image8& mask, int eighths, int width, int height);

/// BT.601 luma of an RGB image.
Image8 Grey(const Image8& image);

/// Share of pixels above 127.
double MaskFraction(const Image8& mask);

}  // namespace keypose::capture
