// Larger copies of linear images.
#pragma once

#include "core/values/image.h"

namespace keypose::synth {

/// The image `factor` times as large, smooth between the pixels (Catmull-Rom splines), without
/// values below 0.
/// @param factor  >= 1; 1 returns the image itself
ImageF Enlarged(ImageF image, int factor);

}  // namespace keypose::synth
