// A picture whose pixels all differ from their neighbours.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/values/image.h"

namespace keypose {

/// Slow waves, other ones in each channel: what any way of averaging agrees on.
inline Image8 Waves(int width, int height) {
  Image8 image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        image.at(x, y)[c] = static_cast<std::uint8_t>(
            std::lround(128 + 60 * std::sin(0.05 * x + c) + 50 * std::cos(0.04 * y + 2 * c)));
  return image;
}

}  // namespace keypose
