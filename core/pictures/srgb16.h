// Conversion between sRGB of 16 bits and linear light.
#pragma once

#include <cstdint>

namespace keypose {

/// Linear light in [0, 1] of each of the 65536 sRGB values. The table is made at the first call:
/// who needs many values keeps the pointer.
const float* LinearTable16();

/// The sRGB value in [0, 1] of linear light, in single precision: right to a hundredth of a step of
/// 16 bits. Values outside [0, 1] are clamped.
float SrgbFraction(float linear);

/// The nearest 16-bit sRGB value of linear light. Values outside [0, 1] are clamped.
std::uint16_t Srgb16Of(float linear);

}  // namespace keypose
