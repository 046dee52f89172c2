// Conversion between stored pictures and linear light by tables.
#pragma once

#include <array>
#include <cstdint>

namespace keypose {

/// Conversion between an 8-bit sRGB value and linear light in [0,1]. The table is outside of the
/// function, because a function-local static would be checked at each of about 10^9 calls.
extern const std::array<float, 256> kLinear;
inline float LinearOf(std::uint8_t srgb) { return kLinear[srgb]; }
std::uint8_t SrgbOf(float linear);

}  // namespace keypose
