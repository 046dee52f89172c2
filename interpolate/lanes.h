// Four doubles at a time, with the elementary functions that faces' paths need.
#pragma once

#include <cstdint>

namespace keypose::interpolation {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"  // everything here is inlined: no vector crosses a call

using Lanes = double __attribute__((vector_size(32)));
using LaneBits = std::int64_t __attribute__((vector_size(32)));

#define KEYPOSE_INLINE inline __attribute__((always_inline))

KEYPOSE_INLINE Lanes Spread(double x) { return Lanes{x, x, x, x}; }
KEYPOSE_INLINE Lanes Select(LaneBits mask, Lanes a, Lanes b) { return (Lanes)(((LaneBits)a & mask) | ((LaneBits)b & ~mask)); }

/// Nearest integers of |x| < 2^51, and those integers' low bits in `bits`.
KEYPOSE_INLINE Lanes Rounded(Lanes x, LaneBits& bits) {
  const Lanes magic = Spread(0x1.8p52), shifted = x + magic;
  bits = (LaneBits)shifted;
  return shifted - magic;
}

/// e^x, within 2 ulp, for |x| <= 700 (clamped beyond). Range reduction by ln 2, then a polynomial of degree 13 (Taylor; |r| <= 0.347).
KEYPOSE_INLINE Lanes Exp(Lanes x) {
  x = Select(x > Spread(700.0), Spread(700.0), x);
  x = Select(x < Spread(-700.0), Spread(-700.0), x);
  LaneBits k;
  const Lanes n = Rounded(x * Spread(1.4426950408889634), k);
  const Lanes r = (x - n * Spread(0x1.62e42feep-1)) - n * Spread(0x1.a39ef35793c76p-33);
  constexpr double kTerms[] = {1.0 / 6227020800, 1.0 / 479001600, 1.0 / 39916800, 1.0 / 3628800, 1.0 / 362880, 1.0 / 40320, 1.0 / 5040,
                               1.0 / 720,        1.0 / 120,       1.0 / 24,       1.0 / 6,       0.5,          1.0,         1.0};
  Lanes p = Spread(kTerms[0]);
#pragma GCC unroll 16
  for (int i = 1; i < 14; ++i) p = p * r + Spread(kTerms[i]);
  return (Lanes)((LaneBits)p + (k << 52));
}

/// Sine and cosine for |r| <= 0.786, by Taylor polynomials.
KEYPOSE_INLINE void SinCosNearZero(Lanes r, Lanes& s, Lanes& c) {
  const Lanes q = r * r;
  constexpr double kSine[] = {-1.0 / 1307674368000, 1.0 / 6227020800, -1.0 / 39916800, 1.0 / 362880, -1.0 / 5040, 1.0 / 120, -1.0 / 6};
  constexpr double kCosine[] = {1.0 / 20922789888000, -1.0 / 87178291200, 1.0 / 479001600, -1.0 / 3628800,
                                1.0 / 40320,          -1.0 / 720,         1.0 / 24};
  s = Spread(kSine[0]), c = Spread(kCosine[0]);
#pragma GCC unroll 8
  for (int i = 1; i < 7; ++i) s = s * q + Spread(kSine[i]), c = c * q + Spread(kCosine[i]);
  s = r + r * q * s;
  c = Spread(1.0) - Spread(0.5) * q + q * q * c;
}

/// Sine and cosine, within 2e-16 of the truth, for |x| up to 1e5. Range reduction by pi/2. Where SinCosNearZero serves, the same bits.
KEYPOSE_INLINE void SinCos(Lanes x, Lanes& sine, Lanes& cosine) {
  LaneBits k;
  const Lanes n = Rounded(x * Spread(0.63661977236758134308), k);
  const Lanes r = ((x - n * Spread(0x1.921fb544p0)) - n * Spread(0x1.0b4611a6p-34)) - n * Spread(0x1.3198a2e037073p-69);
  Lanes s, c;
  SinCosNearZero(r, s, c);
  const LaneBits one = {1, 1, 1, 1}, two = {2, 2, 2, 2};
  const LaneBits odd = (k & one) == one, sine_down = ((k & two) << 62), cosine_down = (((k + one) & two) << 62);
  sine = (Lanes)((LaneBits)Select(odd, c, s) ^ sine_down);
  cosine = (Lanes)((LaneBits)Select(odd, s, c) ^ cosine_down);
}

KEYPOSE_INLINE Lanes Loaded(const double* at) {
  Lanes x;
  __builtin_memcpy(&x, at, sizeof x);
  return x;
}
KEYPOSE_INLINE void Stored(Lanes x, double* at) { __builtin_memcpy(at, &x, sizeof x); }

/// Three numbers a lane.
struct Lanes3 {
  Lanes x, y, z;
};

/// v turned about the unit `axis` (Rodrigues), from the angle's sine and cosine.
KEYPOSE_INLINE Lanes3 Turned(const Lanes3& a, Lanes sine, Lanes cosine, const Lanes3& v) {
  const Lanes along = (a.x * v.x + a.y * v.y + a.z * v.z) * (Spread(1.0) - cosine);
  return {v.x * cosine + (a.y * v.z - a.z * v.y) * sine + a.x * along, v.y * cosine + (a.z * v.x - a.x * v.z) * sine + a.y * along,
          v.z * cosine + (a.x * v.y - a.y * v.x) * sine + a.z * along};
}

/// Functions that are compiled twice: for processors with AVX2 and fused multiply-add, and for any.
#if defined(__x86_64__)
#define KEYPOSE_FMA __attribute__((target("avx2,fma")))
inline bool HasFma() {
  static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  return has;
}
#else
#define KEYPOSE_FMA
inline bool HasFma() { return false; }
#endif

#pragma GCC diagnostic pop

}  // namespace keypose::interpolation
