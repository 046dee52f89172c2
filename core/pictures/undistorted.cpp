#include "core/pictures/undistorted.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"

namespace keypose {

Image8 Undistorted(const Image8& picture, const Camera& camera) {
  Image8 flat(picture.width, picture.height, picture.channels);
  ParallelFor(picture.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < picture.width; ++x) {
      const Eigen::Vector2d from =
          camera.Project({(x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy, 1});
      const double px = std::clamp(from.x() - 0.5, 0.0, picture.width - 1.0),
                   py = std::clamp(from.y() - 0.5, 0.0, picture.height - 1.0);
      const int x0 = static_cast<int>(px), y0 = static_cast<int>(py);
      const int x1 = std::min(x0 + 1, picture.width - 1), y1 = std::min(y0 + 1, picture.height - 1);
      const double fx = px - x0, fy = py - y0;
      for (int c = 0; c < picture.channels; ++c)
        flat.at(x, y)[c] = static_cast<std::uint8_t>(
            std::lround((1 - fy) * ((1 - fx) * picture.at(x0, y0)[c] + fx * picture.at(x1, y0)[c]) +
                        fy * ((1 - fx) * picture.at(x0, y1)[c] + fx * picture.at(x1, y1)[c])));
    }
  });
  return flat;
}

Camera Pinhole(Camera camera) {
  camera.k1 = camera.k2 = camera.p1 = camera.p2 = 0;
  return camera;
}

}  // namespace keypose
