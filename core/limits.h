// Bounds on what is read, so that nothing larger reaches an algorithm.
#pragma once

namespace keypose {

/// Magnitude of a coordinate, in any unit: the ray caster works in single precision, which has no
/// room for much larger numbers' squares and triple products.
inline constexpr double kMostCoordinate = 1e12;

}  // namespace keypose
