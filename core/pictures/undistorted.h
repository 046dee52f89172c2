// Pictures without the bend of their lens.
#pragma once

#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose {

/// The picture as the pinhole camera with the same focal lengths and centre would show it,
/// bilinear. What the lens did not see repeats the border.
/// @param camera  of the picture's size
Image8 Undistorted(const Image8& picture, const Camera& camera);

/// The camera with the same focal lengths, centre and size that bends nothing.
Camera Pinhole(Camera camera);

}  // namespace keypose
