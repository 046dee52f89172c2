// Conversion between sRGB and linear light.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace keypose {

/// Both values are in [0, 1].
/// Source: IEC 61966-2-1.
inline double LinearFromSrgb(double s) {
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}
inline double SrgbFromLinear(double l) {
  return l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
}

/// Linear light in [0, 1] of each 8-bit sRGB value. The tables are outside of functions, because a
/// function-local static would be checked at each of about 10^9 calls.
extern const std::array<float, 256> kLinear;
extern const std::array<double, 256> kLinearDouble;
inline float LinearOf(std::uint8_t srgb) { return kLinear[srgb]; }

/// The 8-bit sRGB value of linear light, by a table: at most one step from the nearest. Values
/// outside [0, 1] are clamped.
std::uint8_t SrgbOf(float linear);

}  // namespace keypose
