// A mask's outline for the search of cameras by outlines.
#pragma once

#include <algorithm>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::reconstruct {

/// A mask as distances to its outline, positive outside, on a coarse raster, with rays through the
/// outline.
struct MaskOutline {
  ImageF distance;                    ///< [px of the coarse raster]
  std::vector<Eigen::Vector3d> rays;  ///< z = 1, by the angle about the mask's centre
  Eigen::Vector3d middle;             ///< ray through the mask's centre of mass
  double area = 0;                    ///< of the mask over f^2
};

/// @param factor  pixels of the mask per pixel of the coarse raster, along each axis
MaskOutline MakeOutline(const Image8& mask, const Camera& camera, int factor);

/// Bilinear; beyond the raster the value at its border.
inline float DistanceAt(const ImageF& raster, double x, double y) {
  const double cx = std::clamp(x - 0.5, 0.0, raster.width - 1.001),
               cy = std::clamp(y - 0.5, 0.0, raster.height - 1.001);
  const int ix = static_cast<int>(cx), iy = static_cast<int>(cy);
  const auto fx = static_cast<float>(cx - ix), fy = static_cast<float>(cy - iy);
  const float* row = raster.at(ix, iy);
  const float* next = raster.at(ix, std::min(iy + 1, raster.height - 1));
  return (1 - fy) * ((1 - fx) * row[0] + fx * row[1]) + fy * ((1 - fx) * next[0] + fx * next[1]);
}

}  // namespace keypose::reconstruct
