#include "core/pictures/pixel_rays.h"

#include <cstdint>

#include "core/numbers/parallel.h"

namespace keypose {

PixelRays::PixelRays(const Camera& camera)
    : stride_(camera.width + 1), corners_(static_cast<std::size_t>(stride_) * (camera.height + 1)) {
  const auto row = [&](std::int64_t y) {
    for (int x = 0; x < stride_; ++x)
      corners_[y * stride_ + x] =
          camera.Unproject(Eigen::Vector2d(x, static_cast<double>(y))).head<2>();
  };
  ParallelFor(camera.height + 1, row, 16);
}

}  // namespace keypose
