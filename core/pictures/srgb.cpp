#include "core/pictures/srgb.h"

#include <algorithm>

namespace keypose {
namespace {

std::array<double, 256> LinearTable() {
  std::array<double, 256> t;
  for (int i = 0; i < 256; ++i) t[i] = LinearFromSrgb(i / 255.0);
  return t;
}

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

const std::array<double, 256> kLinearDouble = LinearTable();
const std::array<float, 256> kLinear = [] {
  std::array<float, 256> t;
  for (int i = 0; i < 256; ++i) t[i] = static_cast<float>(kLinearDouble[i]);
  return t;
}();

std::uint8_t SrgbOf(float linear) {
  return kSrgb[static_cast<int>(std::sqrt(std::clamp(linear, 0.0f, 1.0f)) * 4095 + 0.5f)];
}

}  // namespace keypose
