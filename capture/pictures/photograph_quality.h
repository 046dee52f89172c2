// Sharpness and exposure of the object in a photograph.
#pragma once

#include "core/values/image.h"

namespace keypose::capture {

struct PhotographQuality {
  double laplacian_variance = 0;  ///< grey levels^2; depends on the object's texture
  double crispness = 0;           ///< in [0, 1]: 0 blurred, 1 crisp; hardly depends on the texture
  double exposure = 0;            ///< mean luma, 0..255
  double clipped = 0;             ///< share of pixels at 0..2 or 253..255
};

/// Measures grey values under a mask (of the entire image if the mask is empty or black).
///
/// Crispness compares differences of neighbouring pixels before and after a blur: a crisp picture
/// loses most of them, a blurred one keeps them.
/// Source: Crete, Dolmiere, Ladret & Nicolas, "The blur effect", SPIE 2007; crispness is one minus
/// their measure.
/// @param grey  one channel
/// @param mask  same size, one channel
PhotographQuality MeasureQuality(const Image8& grey, const Image8& mask);

}  // namespace keypose::capture
