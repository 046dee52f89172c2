// The set without the character between two of a moving camera's plates.
#pragma once

#include "core/values/image.h"

namespace keypose::composite {

struct PlateBetweenTwo {
  ImageF picture;       ///< RGB, stored levels, not rounded
  double doubtful = 0;  ///< share of pixels for which the two plates give different colours: what
                        ///< one of them hides, or what was matched wrongly
};

/// Both plates moved along the flow between them to a share of the way, and mixed.
///
/// @param before, after  RGB, stored levels, of one size
/// @param share          of the way from `before`, in (0,1)
/// @throws InputError  two sizes
/// Same bits for any thread count.
/// Source: flow by Farneback, SCIA 2003, as in OpenCV.
PlateBetweenTwo PlateBetween(const ImageF& before, const ImageF& after, double share);

}  // namespace keypose::composite
