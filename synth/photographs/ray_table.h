// Rays through the pixels of a camera with a distorting lens.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/camera.h"

namespace keypose::synth {

/// Points with z = 1 in the camera's frame, at the pixels' corners. Inside a pixel, bilinear
/// interpolation of the distortion is exact to 1e-6 px.
class RayTable {
 public:
  explicit RayTable(const Camera& camera);
  /// @param sx, sy  place inside the pixel, in [0,1]
  Eigen::Vector3d At(int x, int y, double sx, double sy) const {
    const Eigen::Vector2d* c = corners_.data() + static_cast<std::size_t>(y) * stride_ + x;
    const Eigen::Vector2d p = (1 - sy) * ((1 - sx) * c[0] + sx * c[1]) +
                              sy * ((1 - sx) * c[stride_] + sx * c[stride_ + 1]);
    return {p[0], p[1], 1};
  }

 private:
  int stride_;
  std::vector<Eigen::Vector2d> corners_;
};

}  // namespace keypose::synth
