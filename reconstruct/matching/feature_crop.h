// Crops a photograph for feature extraction: the object's box, with the background faded out.
#pragma once

#include "core/values/image.h"

namespace keypose::reconstruct {

/// A photograph cropped to its object.
struct ObjectCrop {
  Image8 image;        ///< grey
  Image8 mask;         ///< the grown mask, 0 or 255, of the same size
  int x0 = 0, y0 = 0;  ///< position of the crop's first pixel in the photograph
};

/// Crops a photograph to the box of its mask and fades distant pixels to the mean grey. So no time
/// and no features are spent on the background, and features near the outline do not describe a
/// background that does not turn with the object.
///
/// @param photo      grey (1 channel)
/// @param mask       of the same size; the object is where it is above 127
/// @param margin_px  the returned mask is the given one grown by this along both axes
/// @return the whole photograph with an empty mask if the mask is empty
/// @throws InputError  sizes or channels that do not fit
ObjectCrop CropToObject(const Image8& photo, const Image8& mask, int margin_px);

}  // namespace keypose::reconstruct
