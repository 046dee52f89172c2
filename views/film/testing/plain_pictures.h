// Pictures of one colour, and of a ball before it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/values/image.h"

namespace keypose {

using Rgb = Eigen::Matrix<std::uint8_t, 3, 1>;

inline Image8 Flat(int width, int height, const Rgb& color) {
  Image8 image(width, height, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = color[i % 3];
  return image;
}

/// A ball with a soft edge that goes across a slow gradient.
inline Image8 BallAt(double x0) {
  Image8 image(160, 120, 3);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const double in = std::clamp(30 - std::hypot(x - x0, y - 60.0), 0.0, 1.0);
      const double ground = 250 - 0.3 * y, red = 200 - y, green = 60 + 0.5 * (x - x0),
                   blue = 40 + y / 2.0;
      const double ball[3] = {red, green, blue};
      for (int k = 0; k < 3; ++k)
        image.at(x, y)[k] = static_cast<std::uint8_t>(
            std::lround(std::clamp(in * ball[k] + (1 - in) * (ground - 2 * k), 0.0, 255.0)));
    }
  return image;
}

}  // namespace keypose
