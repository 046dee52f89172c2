// The window correlation for AVX2 and AVX-512. The latency of a window from warp to cost is about
// 170 cycles, more than out-of-order execution hides. So several independent vectors go through
// each stage together, which saves a third of the time on one core.
#include <algorithm>
#include <cstdint>

#include "views/stereo/patch_match_cost.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace keypose::stereo {

#if defined(__x86_64__)
namespace {

constexpr float kSampleScale = kGreyScale / 16384;  // vertical interpolation has weights of 14 bits

// GCC 12 reports its own _mm512_undefined_* as a read of an uninitialised value.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#define KEYPOSE_AVX2 __attribute__((target("avx2,fma")))
#define KEYPOSE_AVX512 __attribute__((target("avx512f,avx512dq,avx512bw,avx512vl,avx2,fma")))
#define KEYPOSE_EACH(i, n) _Pragma("GCC unroll 8") for (int i = 0; i < (n); ++i)

__attribute__((always_inline)) inline bool Whole(const RefPatch& patch, std::uint32_t used) {
  return (used | patch.unused) == 0xFFFFFFFFu && patch.unused != 0xFFFFFFFFu;
}

// CostOfSums for a window that is entirely in the source's mask, so that w = 1 and r = 0: the
// common case.
__attribute__((always_inline)) inline float WholeCost(const RefPatch& patch, __m128 totals) {
  const float s = totals[0] * kSampleScale, ss = totals[1] * (kSampleScale * kSampleScale),
              rs = totals[2] * kSampleScale;
  const float variance = std::max(0.0f, ss - s * s);
  const float denominator =
      (patch.variance + patch.noise_variance) * (variance + patch.noise_variance);
  if (!(denominator > 1e-8f)) return 1;
  return std::clamp(1 - rs / __builtin_sqrtf(denominator), 0.0f, kWorstCost);
}

KEYPOSE_AVX2 inline __attribute__((always_inline)) __m256i Pairs(const SampleImage& image,
                                                                 __m128i index) {
  return _mm256_i32gather_epi64(reinterpret_cast<const long long*>(image.entries.data()), index, 4);
}

// Half of a window (2 of its 4 vectors) at a time.
struct Avx2Sums {
  __m256 s, ss, rs;
  std::uint32_t used;
};

KEYPOSE_AVX2 inline __attribute__((always_inline)) void Avx2Half(const RefPatch& patch,
                                                                 const SampleImage& image,
                                                                 const WarpLanes& warps, int lane,
                                                                 int half, Avx2Sums* sums) {
  const PatchOffsets& offsets = WindowOffsets();
  const __m256 one = _mm256_set1_ps(1), two = _mm256_set1_ps(2), zero = _mm256_setzero_ps();
  const __m256 right = _mm256_set1_ps(static_cast<float>(image.width - 1)),
               bottom = _mm256_set1_ps(static_cast<float>(image.height - 1));
  __m256 fx[2], fy[2];
  __m256i first[2], second[2];
  KEYPOSE_EACH(v, 2) {
    const __m256 dx = _mm256_load_ps(offsets.dx + 16 * half + 8 * v),
                 dy = _mm256_load_ps(offsets.dy + 16 * half + 8 * v);
    const __m256 z = _mm256_fmadd_ps(dx, _mm256_set1_ps(warps.ex[lane]),
                                     _mm256_fmadd_ps(dy, _mm256_set1_ps(warps.ey[lane]), one));
    __m256 r = _mm256_rcp_ps(z);
    r = _mm256_mul_ps(r, _mm256_fnmadd_ps(z, r, two));
    __m256 x = _mm256_fmadd_ps(dx, _mm256_set1_ps(warps.ax[lane]),
                               _mm256_mul_ps(dy, _mm256_set1_ps(warps.bx[lane])));
    __m256 y = _mm256_fmadd_ps(dx, _mm256_set1_ps(warps.ay[lane]),
                               _mm256_mul_ps(dy, _mm256_set1_ps(warps.by[lane])));
    // Samples outside of the image, and NaNs, are moved to the border, which is in no mask.
    x = _mm256_max_ps(_mm256_min_ps(_mm256_fmadd_ps(x, r, _mm256_set1_ps(warps.x[lane])), right),
                      zero);
    y = _mm256_max_ps(_mm256_min_ps(_mm256_fmadd_ps(y, r, _mm256_set1_ps(warps.y[lane])), bottom),
                      zero);
    const __m256i x0 = _mm256_cvttps_epi32(x), y0 = _mm256_cvttps_epi32(y);
    fx[v] = _mm256_sub_ps(x, _mm256_cvtepi32_ps(x0));
    fy[v] = _mm256_sub_ps(y, _mm256_cvtepi32_ps(y0));
    const __m256i index =
        _mm256_add_epi32(_mm256_mullo_epi32(y0, _mm256_set1_epi32(image.width)), x0);
    first[v] = Pairs(image, _mm256_castsi256_si128(index));
    second[v] = Pairs(image, _mm256_extracti128_si256(index, 1));
  }
  KEYPOSE_EACH(v, 2) {
    const __m256 a = _mm256_castsi256_ps(first[v]), b = _mm256_castsi256_ps(second[v]);
    const __m256i left =
        _mm256_permute4x64_epi64(_mm256_castps_si256(_mm256_shuffle_ps(a, b, 0x88)), 0xD8);
    const __m256i next =
        _mm256_permute4x64_epi64(_mm256_castps_si256(_mm256_shuffle_ps(a, b, 0xDD)), 0xD8);
    const __m256 used = _mm256_castsi256_ps(_mm256_srai_epi32(_mm256_slli_epi32(left, 31), 31));
    sums->used |= static_cast<std::uint32_t>(_mm256_movemask_ps(used)) << (16 * half + 8 * v);
    const __m256i wy = _mm256_cvtps_epi32(_mm256_mul_ps(fy[v], _mm256_set1_ps(16384)));
    // Low half 16384 - wy, high half wy.
    const __m256i weights =
        _mm256_add_epi32(_mm256_sub_epi32(_mm256_slli_epi32(wy, 16), wy), _mm256_set1_epi32(16384));
    const __m256 l = _mm256_cvtepi32_ps(_mm256_madd_epi16(left, weights)),
                 n = _mm256_cvtepi32_ps(_mm256_madd_epi16(next, weights));
    const __m256 s = _mm256_and_ps(used, _mm256_fmadd_ps(_mm256_sub_ps(n, l), fx[v], l));
    const __m256 ws = _mm256_mul_ps(_mm256_load_ps(patch.weight + 16 * half + 8 * v), s);
    sums->s = _mm256_add_ps(sums->s, ws);
    sums->ss = _mm256_fmadd_ps(ws, s, sums->ss);
    sums->rs =
        _mm256_fmadd_ps(_mm256_load_ps(patch.weighted_value + 16 * half + 8 * v), s, sums->rs);
  }
}

// (sum of a, sum of b, sum of c, sum of c).
KEYPOSE_AVX2 inline __attribute__((always_inline)) __m128 Totals(__m256 a, __m256 b, __m256 c) {
  const __m256 t = _mm256_hadd_ps(_mm256_hadd_ps(a, b), _mm256_hadd_ps(c, c));
  return _mm_add_ps(_mm256_castps256_ps128(t), _mm256_extractf128_ps(t, 1));
}

// The reference's sums exclude the lost samples as well.
KEYPOSE_AVX2 __attribute__((noinline)) float PartialCost(const RefPatch& patch, std::uint32_t used,
                                                         __m128 totals) {
  const __m256i bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  __m256 w = _mm256_setzero_ps(), r = w, rr = w;
  KEYPOSE_EACH(v, 4) {
    const __m256i lane =
        _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(used >> (8 * v))), bits);
    const __m256 mask = _mm256_castsi256_ps(_mm256_cmpeq_epi32(lane, bits));
    const __m256 wr = _mm256_and_ps(_mm256_load_ps(patch.weighted_value + 8 * v), mask);
    w = _mm256_add_ps(w, _mm256_and_ps(_mm256_load_ps(patch.weight + 8 * v), mask));
    r = _mm256_add_ps(r, wr);
    rr = _mm256_fmadd_ps(wr, _mm256_load_ps(patch.value + 8 * v), rr);
  }
  const __m128 kept = Totals(w, r, rr);
  const PatchSums sums{kept[0],
                       kept[1],
                       kept[2],
                       totals[0] * kSampleScale,
                       totals[1] * (kSampleScale * kSampleScale),
                       totals[2] * kSampleScale};
  return CostOfSums(sums, patch.noise_variance);
}

KEYPOSE_AVX2 void Avx2Cost(const RefPatch& patch, const SampleImage* const* sources,
                           const WarpLanes& warps, int first, int count, float* costs) {
  for (int k = first; k < first + count; ++k) {
    const __m256 zero = _mm256_setzero_ps();
    Avx2Sums sums{zero, zero, zero, 0};
    Avx2Half(patch, *sources[k], warps, k, 0, &sums);
    Avx2Half(patch, *sources[k], warps, k, 1, &sums);
    const __m128 totals = Totals(sums.s, sums.ss, sums.rs);
    costs[k] =
        Whole(patch, sums.used) ? WholeCost(patch, totals) : PartialCost(patch, sums.used, totals);
  }
}

// Single reads instead of a gather instruction, which is slower on some processors.
KEYPOSE_AVX512 inline __attribute__((always_inline)) __m128i TwoPairs(const std::uint32_t* entries,
                                                                      const int* index) {
  const __m128i one = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(entries + index[0]));
  return _mm_castps_si128(
      _mm_loadh_pi(_mm_castsi128_ps(one), reinterpret_cast<const __m64*>(entries + index[1])));
}
KEYPOSE_AVX512 inline __attribute__((always_inline)) __m512i EightPairs(const SampleImage& image,
                                                                        const int* index) {
  const std::uint32_t* entries = image.entries.data();
  const __m256i low = _mm256_inserti128_si256(_mm256_castsi128_si256(TwoPairs(entries, index)),
                                              TwoPairs(entries, index + 2), 1);
  const __m256i high = _mm256_inserti128_si256(_mm256_castsi128_si256(TwoPairs(entries, index + 4)),
                                               TwoPairs(entries, index + 6), 1);
  return _mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1);
}

KEYPOSE_AVX512 inline __attribute__((always_inline)) __m256 Folded(__m512 a, __m512 b) {
  const __m512 sum = _mm512_add_ps(a, b);
  return _mm256_add_ps(_mm512_castps512_ps256(sum), _mm512_extractf32x8_ps(sum, 1));
}

// Lanes k and k + 1, or k alone: each window is two vectors.
template <int kWindows>
KEYPOSE_AVX512 inline __attribute__((always_inline)) void Avx512Windows(
    const RefPatch& patch, const SampleImage* const* sources, const WarpLanes& warps, int k,
    float* costs) {
  constexpr int kVectors = 2 * kWindows;
  const PatchOffsets& offsets = WindowOffsets();
  const __m512 one = _mm512_set1_ps(1), two = _mm512_set1_ps(2), zero = _mm512_setzero_ps();
  __m512 fx[kVectors], fy[kVectors];
  __m512i index[kVectors], first[kVectors], second[kVectors];
  KEYPOSE_EACH(v, kVectors) {
    const int lane = k + v / 2;
    const SampleImage& image = *sources[lane];
    const __m512 dx = _mm512_load_ps(offsets.dx + 16 * (v & 1)),
                 dy = _mm512_load_ps(offsets.dy + 16 * (v & 1));
    const __m512 z = _mm512_fmadd_ps(dx, _mm512_set1_ps(warps.ex[lane]),
                                     _mm512_fmadd_ps(dy, _mm512_set1_ps(warps.ey[lane]), one));
    __m512 r = _mm512_rcp14_ps(z);
    r = _mm512_mul_ps(r, _mm512_fnmadd_ps(z, r, two));
    __m512 x = _mm512_fmadd_ps(dx, _mm512_set1_ps(warps.ax[lane]),
                               _mm512_mul_ps(dy, _mm512_set1_ps(warps.bx[lane])));
    __m512 y = _mm512_fmadd_ps(dx, _mm512_set1_ps(warps.ay[lane]),
                               _mm512_mul_ps(dy, _mm512_set1_ps(warps.by[lane])));
    // Samples outside of the image, and NaNs, are moved to the border, which is in no mask.
    x = _mm512_min_ps(_mm512_fmadd_ps(x, r, _mm512_set1_ps(warps.x[lane])),
                      _mm512_set1_ps(static_cast<float>(image.width - 1)));
    y = _mm512_min_ps(_mm512_fmadd_ps(y, r, _mm512_set1_ps(warps.y[lane])),
                      _mm512_set1_ps(static_cast<float>(image.height - 1)));
    x = _mm512_max_ps(x, zero);
    y = _mm512_max_ps(y, zero);
    const __m512i x0 = _mm512_cvttps_epi32(x), y0 = _mm512_cvttps_epi32(y);
    fx[v] = _mm512_sub_ps(x, _mm512_cvtepi32_ps(x0));
    fy[v] = _mm512_sub_ps(y, _mm512_cvtepi32_ps(y0));
    index[v] = _mm512_add_epi32(_mm512_mullo_epi32(y0, _mm512_set1_epi32(image.width)), x0);
  }
  KEYPOSE_EACH(v, kVectors) {
    alignas(64) int at[16];
    _mm512_store_si512(at, index[v]);
    first[v] = EightPairs(*sources[k + v / 2], at);
    second[v] = EightPairs(*sources[k + v / 2], at + 8);
  }
  const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
  const __m512i odd = _mm512_add_epi32(even, _mm512_set1_epi32(1));
  __mmask16 used[kVectors];
  __m512 ws[kVectors], wss[kVectors], rs[kVectors];
  KEYPOSE_EACH(v, kVectors) {
    const __m512i left = _mm512_permutex2var_epi32(first[v], even, second[v]),
                  next = _mm512_permutex2var_epi32(first[v], odd, second[v]);
    used[v] = _mm512_test_epi32_mask(left, _mm512_set1_epi32(1));
    const __m512i wy = _mm512_cvtps_epi32(_mm512_mul_ps(fy[v], _mm512_set1_ps(16384)));
    // Low half 16384 - wy, high half wy.
    const __m512i weights =
        _mm512_add_epi32(_mm512_sub_epi32(_mm512_slli_epi32(wy, 16), wy), _mm512_set1_epi32(16384));
    const __m512 l = _mm512_cvtepi32_ps(_mm512_madd_epi16(left, weights)),
                 n = _mm512_cvtepi32_ps(_mm512_madd_epi16(next, weights));
    const __m512 s = _mm512_maskz_fmadd_ps(used[v], _mm512_sub_ps(n, l), fx[v], l);
    ws[v] = _mm512_mul_ps(_mm512_load_ps(patch.weight + 16 * (v & 1)), s);
    wss[v] = _mm512_mul_ps(ws[v], s);
    rs[v] = _mm512_mul_ps(_mm512_load_ps(patch.weighted_value + 16 * (v & 1)), s);
  }
  KEYPOSE_EACH(n, kWindows) {
    const int a = 2 * n, b = 2 * n + 1;
    const __m128 totals =
        Totals(Folded(ws[a], ws[b]), Folded(wss[a], wss[b]), Folded(rs[a], rs[b]));
    const std::uint32_t both = static_cast<std::uint32_t>(used[b]) << 16 | used[a];
    costs[k + n] = Whole(patch, both) ? WholeCost(patch, totals) : PartialCost(patch, both, totals);
  }
}

KEYPOSE_AVX512 void Avx512Cost(const RefPatch& patch, const SampleImage* const* sources,
                               const WarpLanes& warps, int first, int count, float* costs) {
  int k = first;
  for (; k + 1 < first + count; k += 2) Avx512Windows<2>(patch, sources, warps, k, costs);
  if (k < first + count) Avx512Windows<1>(patch, sources, warps, k, costs);
}
#pragma GCC diagnostic pop

}  // namespace

std::vector<PatchCostKernel> SimdPatchCostKernels() {
  std::vector<PatchCostKernel> kernels;
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return kernels;
  kernels.push_back({"avx2", Avx2Cost});
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl"))
    kernels.push_back({"avx512", Avx512Cost});
  return kernels;
}
#else
std::vector<PatchCostKernel> SimdPatchCostKernels() { return {}; }
#endif

}  // namespace keypose::stereo
