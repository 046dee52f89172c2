// Which of a picture's channels tell where a figure is.
#pragma once

#include "core/values/image.h"

namespace keypose {

/// Whether alpha is the mask: it differs between pixels, or hides all of them, as in a frame of a
/// cut-out where nobody is. Opaque all over it says nothing.
/// @param alpha  H x W x 1; empty where there is none, which is no mask
bool AlphaIsMask(const Image8& alpha);

/// Whether a hundredth of the pixels has channels that differ by more than noise.
/// @param rgb  H x W x 3, of 255
bool IsColoured(const ImageF& rgb);
/// H x W x 1: red on black is a mask as white on black is.
ImageF BrightestChannel(const ImageF& rgb);

/// The same numbers as levels of 255.
ImageF AsLevels(const Image8& image);

}  // namespace keypose
