#include "core/pictures/srgb16.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/pictures/srgb.h"

namespace keypose {

const float* LinearTable16() {
  static const std::vector<float> table = [] {
    std::vector<float> t(65536);
    for (int i = 0; i < 65536; ++i) t[i] = static_cast<float>(LinearFromSrgb(i / 65535.0));
    return t;
  }();
  return table.data();
}

float SrgbFraction(float linear) {
  const float l = std::clamp(linear, 0.0f, 1.0f);
  return l <= 0.0031308f ? 12.92f * l : 1.055f * std::pow(l, 1 / 2.4f) - 0.055f;
}

std::uint16_t Srgb16Of(float linear) {
  return static_cast<std::uint16_t>(std::lround(65535 * SrgbFraction(linear)));
}

}  // namespace keypose
