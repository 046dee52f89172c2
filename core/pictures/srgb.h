// Conversion between sRGB and linear light.
#pragma once

#include <cmath>

namespace keypose {

/// Both values are in [0, 1].
/// Source: IEC 61966-2-1.
inline double LinearFromSrgb(double s) {
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}
inline double SrgbFromLinear(double l) {
  return l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
}

}  // namespace keypose
