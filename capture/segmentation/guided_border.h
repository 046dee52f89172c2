// Carries the border of a small mask to a picture many times its size.
#pragma once

#include "core/values/image.h"

namespace keypose::capture {

/// A guided filter whose coefficients are found at a fraction of the picture's size: with windows
/// of four pixels each way there, it takes a tenth of the filter's time and memory.
///
/// @param image   RGB
/// @param mask    one channel, of the same picture at a smaller size; 255 or 0
/// @param radius  of the filter's windows in the picture [px], at least 8
/// @param noise   standard deviation below which differences of colour are no edge [8 bit levels]
/// @return 255 or 0, of the picture's size
/// Source: He, Sun & Tang, "Guided image filtering", ECCV 2010, Eq. 14-16 (three colours); He &
/// Sun, "Fast guided filter", arXiv 1505.00996, 2015 (coefficients at a fraction of the size).
Image8 GuidedMask(const Image8& image, const Image8& mask, int radius, double noise);

}  // namespace keypose::capture
