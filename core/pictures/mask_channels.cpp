#include "core/pictures/mask_channels.h"

#include <algorithm>

namespace keypose {

bool AlphaIsMask(const Image8& alpha) {
  if (alpha.empty()) return false;
  const std::uint8_t first = alpha.data.front();
  return first == 0 || std::any_of(alpha.data.begin(), alpha.data.end(),
                                   [&](std::uint8_t value) { return value != first; });
}

ImageF AsLevels(const Image8& image) {
  ImageF levels(image.width, image.height, image.channels);
  std::copy(image.data.begin(), image.data.end(), levels.data.begin());
  return levels;
}

}  // namespace keypose
