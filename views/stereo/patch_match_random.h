// Random numbers for plane changes.
#pragma once

#include <cstdint>

namespace keypose::stereo {

/// A generator whose numbers depend on the seed alone: small and fast.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  /// In [-1, 1).
  float Signed() {
    return static_cast<float>(static_cast<std::int64_t>(Next() >> 40) - (1 << 23)) *
           (1.0f / (1 << 23));
  }
  /// In [0, 1).
  float Unit() { return static_cast<float>(Next() >> 40) * (1.0f / (1 << 24)); }

 private:
  std::uint64_t Next() {  // splitmix64
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

}  // namespace keypose::stereo
