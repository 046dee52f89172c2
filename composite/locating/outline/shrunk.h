// Smaller pictures.
#pragma once

#include "core/values/image.h"

namespace keypose::composite {

/// The picture with `width` x `height` pixels, each the mean of what it covers. Any channels.
/// @pre not larger than the picture, at least 1 x 1
Image8 Shrunk(const Image8& picture, int width, int height);

}  // namespace keypose::composite
