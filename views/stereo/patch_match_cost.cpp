#include "views/stereo/patch_match_cost.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace keypose::stereo {
namespace {

constexpr int kTableShift = 5;  // a quarter of a grey level
constexpr float kLostWeightLimit = 0.5f;
// so that a plane does not gain when its window leaves the source's mask
constexpr float kLostWeightPenalty = 0.2f;

PatchOffsets MakeOffsets() {
  PatchOffsets offsets;
  int k = 0;
  for (int y = -kPatchRadius; y <= kPatchRadius; y += 2)
    for (int x = -kPatchRadius; x <= kPatchRadius; x += 2) {
      if (std::abs(x) == kPatchRadius && std::abs(y) == kPatchRadius) continue;
      offsets.dx[k] = static_cast<float>(x);
      offsets.dy[k] = static_cast<float>(y);
      ++k;
    }
  return offsets;
}

// |offset| and |grey difference|, not their squares, as in ACMM.
struct SampleTable {
  std::array<int, kPatchSamples> dx, dy;
  std::array<float, kPatchSamples> weight;
};
SampleTable MakeTable(Window window) {
  SampleTable t;
  for (int k = 0; k < kPatchSamples; ++k) {
    const float x = WindowOffsets().dx[k], y = WindowOffsets().dy[k];
    t.dx[k] = static_cast<int>(std::lround(x * WindowScale(window) + WindowMiddle(window)));
    t.dy[k] = static_cast<int>(std::lround(y * WindowScale(window) + WindowMiddle(window)));
    t.weight[k] = std::exp(-std::hypot(x, y) / (2.0f * kPatchRadius * kPatchRadius));
  }
  return t;
}
const SampleTable& TableOf(Window window) {
  static const SampleTable wide = MakeTable(Window::kWide), narrow = MakeTable(Window::kNarrow);
  return window == Window::kNarrow ? narrow : wide;
}

using Four = float __attribute__((vector_size(4 * sizeof(float))));
Four Load(const float* from) {
  Four four;
  std::memcpy(&four, from, sizeof four);
  return four;
}
void Store(const Four& four, float* to) { std::memcpy(to, &four, sizeof four); }
float Total(const Four& four) { return (four[0] + four[1]) + (four[2] + four[3]); }

float Low(std::uint32_t entry) { return static_cast<std::int16_t>(entry & 0xFFFF); }
float High(std::uint32_t entry) { return static_cast<std::int16_t>(entry >> 16); }

float ScalarCostOf(const RefPatch& patch, const SampleImage& source, const WarpLanes& warps,
                   int lane) {
  const PatchOffsets& offsets = WindowOffsets();
  const float right = static_cast<float>(source.width - 1),
              bottom = static_cast<float>(source.height - 1);
  PatchSums sums{};
  for (int k = 0; k < kPatchSamples; ++k) {
    const float dx = offsets.dx[k], dy = offsets.dy[k];
    const float r = 1 / (1 + dx * warps.ex[lane] + dy * warps.ey[lane]);
    const float x = warps.x[lane] + (dx * warps.ax[lane] + dy * warps.bx[lane]) * r;
    const float y = warps.y[lane] + (dx * warps.ay[lane] + dy * warps.by[lane]) * r;
    if (!(x >= 0 && y >= 0 && x < right && y < bottom)) continue;
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const std::uint32_t* entry =
        source.entries.data() + static_cast<std::size_t>(y0) * source.width + x0;
    if (!(entry[0] & 1)) continue;
    const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
    const float left = Low(entry[0]) * (1 - fy) + High(entry[0]) * fy,
                next = Low(entry[1]) * (1 - fy) + High(entry[1]) * fy;
    const float s = (left + (next - left) * fx) * kGreyScale;
    const float w = patch.weight[k], wr = patch.weighted_value[k];
    sums.w += w;
    sums.r += wr;
    sums.rr += wr * patch.value[k];
    sums.s += w * s;
    sums.ss += w * s * s;
    sums.rs += wr * s;
  }
  return CostOfSums(sums, patch.noise_variance);
}

void ScalarCost(const RefPatch& patch, const SampleImage* const* sources, const WarpLanes& warps,
                int first, int count, float* costs) {
  for (int k = first; k < first + count; ++k) costs[k] = ScalarCostOf(patch, *sources[k], warps, k);
}

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

float CostOfSums(const PatchSums& sums, float noise_variance) {
  const float lost = 1 - sums.w;
  if (!(lost <= kLostWeightLimit)) return kWorstCost;  // also when the window has no weight
  const float inverse = 1 / sums.w;
  const float mean_r = sums.r * inverse, mean_s = sums.s * inverse;
  const float var_r = std::max(0.0f, sums.rr * inverse - mean_r * mean_r);
  const float var_s = std::max(0.0f, sums.ss * inverse - mean_s * mean_s);
  const float denominator = (var_r + noise_variance) * (var_s + noise_variance);
  if (!(denominator > 1e-8f)) return 1 + kLostWeightPenalty * lost;
  const float ncc = (sums.rs * inverse - mean_r * mean_s) / std::sqrt(denominator);
  return std::clamp(1 - ncc + kLostWeightPenalty * lost, 0.0f, kWorstCost);
}

BilateralTable::BilateralTable(float color_scale) {
  for (int i = 0; i < kSize; ++i)
    similarity[i] = std::exp(
        -(static_cast<float>((i << kTableShift) + (1 << (kTableShift - 1))) * (255.0f / 32767.0f)) /
        color_scale);
}

void FillRefPatch(const GreyMask& image, int x, int y, const BilateralTable& table,
                  float noise_variance, RefPatch* patch, Window window) {
  alignas(16) std::array<std::uint16_t, kPatchSamples> pixels;
  alignas(16) std::array<float, kPatchSamples> similarity;
  const SampleTable& samples = TableOf(window);
  const int *dx = samples.dx.data(), *dy = samples.dy.data();
  const float* spatial = samples.weight.data();
  if (x >= kPatchRadius && y >= kPatchRadius && x + kPatchRadius < image.width &&
      y + kPatchRadius < image.height) {
    const std::uint16_t* here = image.at(x, y);
    for (int k = 0; k < kPatchSamples; ++k) pixels[k] = here[dy[k] * image.width + dx[k]];
  } else {
    for (int k = 0; k < kPatchSamples; ++k) {
      const int sx = x + dx[k], sy = y + dy[k];
      pixels[k] =
          sx < 0 || sy < 0 || sx >= image.width || sy >= image.height ? 0 : *image.at(sx, sy);
    }
  }
  const int center = *image.at(x, y) >> 1;
  patch->unused = 0;
  for (int k = 0; k < kPatchSamples; ++k) {
    const int inside = pixels[k] & 1;
    similarity[k] =
        inside ? table.similarity[std::abs((pixels[k] >> 1) - center) >> kTableShift] : 0;
    patch->unused |= static_cast<std::uint32_t>(inside ^ 1) << k;
  }
  // Four samples at a time.
  Four weights{}, sums{}, squares{};
  for (int k = 0; k < kPatchSamples; k += 4) {
    const Four value = Four{static_cast<float>(pixels[k]), static_cast<float>(pixels[k + 1]),
                            static_cast<float>(pixels[k + 2]), static_cast<float>(pixels[k + 3])} *
                       kGreyScale;
    const Four weight = Load(spatial + k) * Load(similarity.data() + k);
    Store(value, patch->value + k);
    Store(weight, patch->weight + k);
    weights += weight;
    sums += weight * value;
  }
  const float weight_sum = Total(weights), inverse = weight_sum > 0 ? 1 / weight_sum : 0,
              mean = Total(sums) * inverse;
  for (int k = 0; k < kPatchSamples; k += 4) {
    const Four weight = Load(patch->weight + k) * inverse, value = Load(patch->value + k) - mean,
               weighted = weight * value;
    Store(weight, patch->weight + k);
    Store(value, patch->value + k);
    Store(weighted, patch->weighted_value + k);
    squares += weighted * value;
  }
  patch->variance = Total(squares);
  patch->noise_variance = noise_variance;
}

SampleImage MakeSampleImage(const GreyMask& image) {
  SampleImage out{image.width + 2, image.height + 2, {}};
  out.entries.assign(static_cast<std::size_t>(out.width) * out.height + 1,
                     0);  // the last entry is read with its right neighbour
  auto signed16 = [](std::uint16_t pixel) { return static_cast<std::uint32_t>(pixel ^ 0x8000u); };
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::uint16_t here = *image.at(x, y),
                          below = y + 1 < image.height ? *image.at(x, y + 1) : 0;
      const bool has_right = x + 1 < image.width;
      const std::uint16_t right = has_right ? *image.at(x + 1, y) : 0;
      const std::uint16_t corner = has_right && y + 1 < image.height ? *image.at(x + 1, y + 1) : 0;
      const std::uint32_t all = here & below & right & corner & 1u;
      out.entries[static_cast<std::size_t>(y + 1) * out.width + x + 1] =
          (signed16(here) & ~1u) | all | signed16(below) << 16;
    }
  return out;
}

std::vector<PatchCostKernel> AvailablePatchCostKernels() {
  std::vector<PatchCostKernel> kernels = {{"scalar", ScalarCost}};
  for (PatchCostKernel& kernel : SimdPatchCostKernels()) kernels.push_back(std::move(kernel));
  return kernels;
}

const PatchCostKernel& BestPatchCostKernel() {
  static const PatchCostKernel kernel = ChooseKernel();
  return kernel;
}

}  // namespace keypose::stereo
