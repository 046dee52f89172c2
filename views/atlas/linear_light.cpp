#include "views/atlas/linear_light.h"

#include <algorithm>
#include <cmath>

#include "core/pictures/srgb.h"

namespace keypose {
namespace {

/// Indexed by the square root: fine for dark values, where sRGB is steep.
std::array<std::uint8_t, 4096> SrgbTable() {
  std::array<std::uint8_t, 4096> t;
  for (int i = 0; i < 4096; ++i) {
    const double l = (i / 4095.0) * (i / 4095.0);
    t[i] = static_cast<std::uint8_t>(std::lround(255 * SrgbFromLinear(l)));
  }
  return t;
}
const std::array<std::uint8_t, 4096> kSrgb = SrgbTable();

}  // namespace

const std::array<float, 256> kLinear = [] {
  std::array<float, 256> t;
  for (int i = 0; i < 256; ++i) t[i] = static_cast<float>(LinearFromSrgb(i / 255.0));
  return t;
}();

std::uint8_t SrgbOf(float linear) {
  return kSrgb[static_cast<int>(std::sqrt(std::clamp(linear, 0.0f, 1.0f)) * 4095 + 0.5f)];
}

}  // namespace keypose
