#include "reconstruct/patch_match_cost.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#if defined(__x86_64__)
#include <immintrin.h>
#define KEYPOSE_X86_KERNELS 1
#endif

namespace keypose::reconstruct {
namespace {

constexpr int kTableShift = 5;  // a quarter of a grey level
constexpr float kLostWeightLimit = 0.5f;
constexpr float kLostWeightPenalty = 0.2f;  // a plane must not gain by pushing its window out of the source's mask

PatchOffsets MakeOffsets() {
  PatchOffsets offsets;
  int k = 0;
  for (int y = -kPatchRadius; y <= kPatchRadius; y += 2)
    for (int x = -kPatchRadius; x <= kPatchRadius; x += 2) {
      if (std::abs(x) == kPatchRadius && std::abs(y) == kPatchRadius) continue;
      offsets.dx[k] = static_cast<float>(x), offsets.dy[k] = static_cast<float>(y);
      ++k;
    }
  return offsets;
}

// Weighted sums over the samples that lie inside the source's mask.
struct Sums {
  float w, r, rr, s, ss, rs;
};

__attribute__((always_inline)) inline float CostOf(const Sums& sums, const RefPatch& patch, float noise_variance) {
  const float lost = 1 - sums.w / patch.weight_sum;
  if (!(lost <= kLostWeightLimit)) return kWorstCost;  // also when the window has no weight at all
  const float inverse = 1 / sums.w;
  const float mean_r = sums.r * inverse, mean_s = sums.s * inverse;
  const float var_r = std::max(0.0f, sums.rr * inverse - mean_r * mean_r);
  const float var_s = std::max(0.0f, sums.ss * inverse - mean_s * mean_s);
  const float denominator = (var_r + noise_variance) * (var_s + noise_variance);
  if (!(denominator > 1e-8f)) return 1 + kLostWeightPenalty * lost;
  const float ncc = (sums.rs * inverse - mean_r * mean_s) / std::sqrt(denominator);
  return std::clamp(1 - ncc + kLostWeightPenalty * lost, 0.0f, kWorstCost);
}

float ScalarCost(const RefPatch& patch, const GreyMask& source, const PatchWarp& warp, float noise_variance) {
  const PatchOffsets& offsets = WindowOffsets();
  const float right = static_cast<float>(source.width - 1), bottom = static_cast<float>(source.height - 1);
  Sums sums{};
  for (int k = 0; k < kPatchSamples; ++k) {
    const float dx = offsets.dx[k], dy = offsets.dy[k];
    const float z = warp.h0[2] + dx * warp.hx[2] + dy * warp.hy[2];
    const float x = (warp.h0[0] + dx * warp.hx[0] + dy * warp.hy[0]) / z;
    const float y = (warp.h0[1] + dx * warp.hx[1] + dy * warp.hy[1]) / z;
    if (!(z > 0 && x >= 0 && y >= 0 && x < right && y < bottom)) continue;
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const std::uint16_t* top = source.at(x0, y0);
    const std::uint16_t* low = top + source.width;
    if (!(top[0] & top[1] & low[0] & low[1] & 1)) continue;
    const float fx = x - x0, fy = y - y0;
    const float a = top[0] + (static_cast<float>(top[1]) - top[0]) * fx;
    const float b = low[0] + (static_cast<float>(low[1]) - low[0]) * fx;
    const float value = (a + (b - a) * fy) * kGreyScale - patch.offset;
    const float w = patch.weight[k], r = patch.value[k];
    sums.w += w, sums.r += w * r, sums.rr += w * r * r;
    sums.s += w * value, sums.ss += w * value * value, sums.rs += w * r * value;
  }
  return CostOf(sums, patch, noise_variance);
}

#if KEYPOSE_X86_KERNELS
// GCC 12 takes its own _mm512_undefined_* for a read of an uninitialised value.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
__attribute__((target("avx2,fma"))) inline float Total(__m256 v) {
  const __m128 four = _mm_add_ps(_mm256_castps256_ps128(v), _mm256_extractf128_ps(v, 1));
  const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)));
}

__attribute__((target("avx2,fma"))) float Avx2Cost(const RefPatch& patch, const GreyMask& source, const PatchWarp& warp,
                                                   float noise_variance) {
  const PatchOffsets& offsets = WindowOffsets();
  const __m256 zero = _mm256_setzero_ps(), one = _mm256_set1_ps(1.0f);
  const __m256 right = _mm256_set1_ps(static_cast<float>(source.width - 1)), bottom = _mm256_set1_ps(static_cast<float>(source.height - 1));
  const __m256i last_x = _mm256_set1_epi32(source.width - 2), last_y = _mm256_set1_epi32(source.height - 2);
  const __m256i stride = _mm256_set1_epi32(source.width), low_half = _mm256_set1_epi32(0xFFFF), bit = _mm256_set1_epi32(1);
  const int* top_row = reinterpret_cast<const int*>(source.data.data());
  const int* low_row = reinterpret_cast<const int*>(source.data.data() + source.width);
  __m256 sw = zero, sr = zero, srr = zero, ss = zero, sss = zero, srs = zero;
  for (int k = 0; k < kPatchSamples; k += 8) {
    const __m256 dx = _mm256_load_ps(offsets.dx + k), dy = _mm256_load_ps(offsets.dy + k);
    auto warped = [&](int i) __attribute__((target("avx2,fma"))) {
      return _mm256_fmadd_ps(dx, _mm256_set1_ps(warp.hx[i]), _mm256_fmadd_ps(dy, _mm256_set1_ps(warp.hy[i]), _mm256_set1_ps(warp.h0[i])));
    };
    const __m256 z = warped(2), inverse = _mm256_div_ps(one, z);
    const __m256 x = _mm256_mul_ps(warped(0), inverse), y = _mm256_mul_ps(warped(1), inverse);
    __m256 inside = _mm256_and_ps(_mm256_cmp_ps(x, zero, _CMP_GE_OQ), _mm256_cmp_ps(y, zero, _CMP_GE_OQ));
    inside = _mm256_and_ps(inside, _mm256_and_ps(_mm256_cmp_ps(x, right, _CMP_LT_OQ), _mm256_cmp_ps(y, bottom, _CMP_LT_OQ)));
    inside = _mm256_and_ps(inside, _mm256_cmp_ps(z, zero, _CMP_GT_OQ));
    // Lanes outside read the nearest legal pixel and are given no weight.
    const __m256i x0 = _mm256_max_epi32(_mm256_min_epi32(_mm256_cvttps_epi32(x), last_x), _mm256_setzero_si256());
    const __m256i y0 = _mm256_max_epi32(_mm256_min_epi32(_mm256_cvttps_epi32(y), last_y), _mm256_setzero_si256());
    const __m256 fx = _mm256_sub_ps(x, _mm256_cvtepi32_ps(x0)), fy = _mm256_sub_ps(y, _mm256_cvtepi32_ps(y0));
    const __m256i index = _mm256_add_epi32(_mm256_mullo_epi32(y0, stride), x0);
    const __m256i top = _mm256_i32gather_epi32(top_row, index, 2), low = _mm256_i32gather_epi32(low_row, index, 2);
    const __m256i both = _mm256_and_si256(top, low);
    const __m256i masked = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_and_si256(both, _mm256_srli_epi32(both, 16)), bit), bit);
    const __m256 t0 = _mm256_cvtepi32_ps(_mm256_and_si256(top, low_half)), t1 = _mm256_cvtepi32_ps(_mm256_srli_epi32(top, 16));
    const __m256 l0 = _mm256_cvtepi32_ps(_mm256_and_si256(low, low_half)), l1 = _mm256_cvtepi32_ps(_mm256_srli_epi32(low, 16));
    const __m256 a = _mm256_fmadd_ps(_mm256_sub_ps(t1, t0), fx, t0), b = _mm256_fmadd_ps(_mm256_sub_ps(l1, l0), fx, l0);
    const __m256 grey = _mm256_fmadd_ps(_mm256_sub_ps(b, a), fy, a);
    const __m256 used = _mm256_and_ps(inside, _mm256_castsi256_ps(masked));
    const __m256 w = _mm256_and_ps(_mm256_load_ps(patch.weight + k), used);
    const __m256 r = _mm256_load_ps(patch.value + k);
    const __m256 s = _mm256_and_ps(used, _mm256_fmsub_ps(grey, _mm256_set1_ps(kGreyScale), _mm256_set1_ps(patch.offset)));
    const __m256 wr = _mm256_mul_ps(w, r), ws = _mm256_mul_ps(w, s);
    sw = _mm256_add_ps(sw, w), sr = _mm256_add_ps(sr, wr), ss = _mm256_add_ps(ss, ws);
    srr = _mm256_fmadd_ps(wr, r, srr), sss = _mm256_fmadd_ps(ws, s, sss), srs = _mm256_fmadd_ps(wr, s, srs);
  }
  return CostOf({Total(sw), Total(sr), Total(srr), Total(ss), Total(sss), Total(srs)}, patch, noise_variance);
}

__attribute__((target("avx512f,avx512dq,avx512bw,avx512vl"))) float Avx512Cost(const RefPatch& patch, const GreyMask& source,
                                                                               const PatchWarp& warp, float noise_variance) {
  const PatchOffsets& offsets = WindowOffsets();
  const __m512 zero = _mm512_setzero_ps(), one = _mm512_set1_ps(1.0f);
  const __m512 right = _mm512_set1_ps(static_cast<float>(source.width - 1)), bottom = _mm512_set1_ps(static_cast<float>(source.height - 1));
  const __m512i stride = _mm512_set1_epi32(source.width), low_half = _mm512_set1_epi32(0xFFFF);
  const std::uint16_t* top_row = source.data.data();
  const std::uint16_t* low_row = source.data.data() + source.width;
  __m512 sw = zero, sr = zero, srr = zero, ss = zero, sss = zero, srs = zero;
  for (int k = 0; k < kPatchSamples; k += 16) {
    const __m512 dx = _mm512_load_ps(offsets.dx + k), dy = _mm512_load_ps(offsets.dy + k);
    auto warped = [&](int i) __attribute__((target("avx512f,avx512dq,avx512bw,avx512vl"))) {
      return _mm512_fmadd_ps(dx, _mm512_set1_ps(warp.hx[i]), _mm512_fmadd_ps(dy, _mm512_set1_ps(warp.hy[i]), _mm512_set1_ps(warp.h0[i])));
    };
    const __m512 z = warped(2), inverse = _mm512_div_ps(one, z);
    const __m512 x = _mm512_mul_ps(warped(0), inverse), y = _mm512_mul_ps(warped(1), inverse);
    __mmask16 inside = _mm512_cmp_ps_mask(x, zero, _CMP_GE_OQ) & _mm512_cmp_ps_mask(y, zero, _CMP_GE_OQ);
    inside &=
        _mm512_cmp_ps_mask(x, right, _CMP_LT_OQ) & _mm512_cmp_ps_mask(y, bottom, _CMP_LT_OQ) & _mm512_cmp_ps_mask(z, zero, _CMP_GT_OQ);
    const __m512i x0 = _mm512_cvttps_epi32(x), y0 = _mm512_cvttps_epi32(y);
    const __m512 fx = _mm512_sub_ps(x, _mm512_cvtepi32_ps(x0)), fy = _mm512_sub_ps(y, _mm512_cvtepi32_ps(y0));
    const __m512i index = _mm512_add_epi32(_mm512_mullo_epi32(y0, stride), x0);
    const __m512i none = _mm512_setzero_si512();
    const __m512i top = _mm512_mask_i32gather_epi32(none, inside, index, top_row, 2);
    const __m512i low = _mm512_mask_i32gather_epi32(none, inside, index, low_row, 2);
    const __m512i both = _mm512_and_si512(top, low);
    const __mmask16 used = _mm512_test_epi32_mask(_mm512_and_si512(both, _mm512_srli_epi32(both, 16)), _mm512_set1_epi32(1));
    const __m512 t0 = _mm512_cvtepi32_ps(_mm512_and_si512(top, low_half)), t1 = _mm512_cvtepi32_ps(_mm512_srli_epi32(top, 16));
    const __m512 l0 = _mm512_cvtepi32_ps(_mm512_and_si512(low, low_half)), l1 = _mm512_cvtepi32_ps(_mm512_srli_epi32(low, 16));
    const __m512 a = _mm512_fmadd_ps(_mm512_sub_ps(t1, t0), fx, t0), b = _mm512_fmadd_ps(_mm512_sub_ps(l1, l0), fx, l0);
    const __m512 grey = _mm512_fmadd_ps(_mm512_sub_ps(b, a), fy, a);
    const __m512 w = _mm512_maskz_load_ps(used, patch.weight + k), r = _mm512_load_ps(patch.value + k);
    const __m512 s = _mm512_maskz_fmsub_ps(used, grey, _mm512_set1_ps(kGreyScale), _mm512_set1_ps(patch.offset));
    const __m512 wr = _mm512_mul_ps(w, r), ws = _mm512_mul_ps(w, s);
    sw = _mm512_add_ps(sw, w), sr = _mm512_add_ps(sr, wr), ss = _mm512_add_ps(ss, ws);
    srr = _mm512_fmadd_ps(wr, r, srr), sss = _mm512_fmadd_ps(ws, s, sss), srs = _mm512_fmadd_ps(wr, s, srs);
  }
  return CostOf({_mm512_reduce_add_ps(sw), _mm512_reduce_add_ps(sr), _mm512_reduce_add_ps(srr), _mm512_reduce_add_ps(ss),
                 _mm512_reduce_add_ps(sss), _mm512_reduce_add_ps(srs)},
                patch, noise_variance);
}
#pragma GCC diagnostic pop
#endif

PatchCostKernel ChooseKernel() {
  const std::vector<PatchCostKernel> kernels = AvailablePatchCostKernels();
  const char* wanted = std::getenv("KEYPOSE_SIMD");
  for (const PatchCostKernel& kernel : kernels)
    if (wanted && kernel.name == wanted) return kernel;
  return kernels.back();
}

}  // namespace

const PatchOffsets& WindowOffsets() {
  static const PatchOffsets offsets = MakeOffsets();
  return offsets;
}

BilateralTable::BilateralTable(float color_scale) {
  for (int i = 0; i < kSize; ++i)
    similarity[i] = std::exp(-(static_cast<float>((i << kTableShift) + (1 << (kTableShift - 1))) * (255.0f / 32767.0f)) / color_scale);
}

void FillRefPatch(const GreyMask& image, int x, int y, const BilateralTable& table, RefPatch* patch) {
  // |offset| and |grey difference|, not their squares, as in ACMM.
  static const std::array<float, kPatchSamples> spatial = [] {
    std::array<float, kPatchSamples> weights;
    for (int k = 0; k < kPatchSamples; ++k)
      weights[k] = std::exp(-std::hypot(WindowOffsets().dx[k], WindowOffsets().dy[k]) / (2.0f * kPatchRadius * kPatchRadius));
    return weights;
  }();
  const PatchOffsets& offsets = WindowOffsets();
  const int center = *image.at(x, y) >> 1;
  float weight_sum = 0, sum = 0;
  for (int k = 0; k < kPatchSamples; ++k) {
    const int sx = x + static_cast<int>(offsets.dx[k]), sy = y + static_cast<int>(offsets.dy[k]);
    patch->weight[k] = patch->value[k] = 0;
    if (sx < 0 || sy < 0 || sx >= image.width || sy >= image.height) continue;
    const std::uint16_t pixel = *image.at(sx, sy);
    if (!InMask(pixel)) continue;
    const float grey = pixel * kGreyScale;
    patch->value[k] = grey;
    patch->weight[k] = spatial[k] * table.similarity[std::abs((pixel >> 1) - center) >> kTableShift];
    weight_sum += patch->weight[k];
    sum += patch->weight[k] * grey;
  }
  patch->weight_sum = weight_sum;
  patch->offset = weight_sum > 0 ? sum / weight_sum : 0;
  float squares = 0;
  for (int k = 0; k < kPatchSamples; ++k) {
    patch->value[k] -= patch->offset;
    squares += patch->weight[k] * patch->value[k] * patch->value[k];
  }
  patch->variance = weight_sum > 0 ? squares / weight_sum : 0;
}

std::vector<PatchCostKernel> AvailablePatchCostKernels() {
  std::vector<PatchCostKernel> kernels = {{"scalar", ScalarCost}};
#if KEYPOSE_X86_KERNELS
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    kernels.push_back({"avx2", Avx2Cost});
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512vl"))
      kernels.push_back({"avx512", Avx512Cost});
  }
#endif
  return kernels;
}

const PatchCostKernel& BestPatchCostKernel() {
  static const PatchCostKernel kernel = ChooseKernel();
  return kernel;
}

}  // namespace keypose::reconstruct
