// Limits on values that are read from files.
#pragma once

namespace keypose {

/// Largest magnitude of a coordinate, in any unit. The ray caster works in single precision, where
/// the squares and triple products of much larger numbers overflow.
inline constexpr double kMostCoordinate = 1e12;

}  // namespace keypose
