#include "core/pictures/mask_channels.h"

#include <algorithm>

namespace keypose {

bool AlphaIsMask(const Image8& alpha) {
  if (alpha.empty()) return false;
  const std::uint8_t first = alpha.data.front();
  return first == 0 || std::any_of(alpha.data.begin(), alpha.data.end(),
                                   [&](std::uint8_t value) { return value != first; });
}

bool IsColoured(const ImageF& rgb) {
  constexpr float kGrey = 24;
  constexpr double kColouredShare = 0.01;
  const std::size_t pixels = rgb.data.size() / 3;
  std::size_t coloured = 0;
  for (std::size_t p = 0; p < pixels; ++p) {
    const auto [low, high] =
        std::minmax({rgb.data[3 * p], rgb.data[3 * p + 1], rgb.data[3 * p + 2]});
    coloured += high - low > kGrey;
  }
  return static_cast<double>(coloured) >= kColouredShare * static_cast<double>(pixels);
}

ImageF BrightestChannel(const ImageF& rgb) {
  ImageF grey(rgb.width, rgb.height, 1);
  for (std::size_t p = 0; p < grey.data.size(); ++p)
    grey.data[p] = std::max({rgb.data[3 * p], rgb.data[3 * p + 1], rgb.data[3 * p + 2]});
  return grey;
}

ImageF AsLevels(const Image8& image) {
  ImageF levels(image.width, image.height, image.channels);
  std::copy(image.data.begin(), image.data.end(), levels.data.begin());
  return levels;
}

}  // namespace keypose
