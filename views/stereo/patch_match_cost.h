// The photometric cost of a plane hypothesis: one minus the bilaterally weighted correlation of a
// window in two photographs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "views/prepared/prepared_view.h"

namespace keypose::stereo {

/// Window: 11 x 11 with step 2 and without its corners, so that its 32 samples fill four AVX2 or
/// two AVX-512 registers. The narrow window has the same samples with step 1: 6 x 6 pixels, whose
/// middle is half a pixel to the right of and below its pixel. In units of half a pixel about that
/// middle it has the same offsets as the wide window, so kernels treat both alike.
enum class Window { kWide, kNarrow };
constexpr float WindowScale(Window window) {
  return window == Window::kNarrow ? 0.5f : 1.0f;
}  ///< pixels in an offset's unit
constexpr float WindowMiddle(Window window) {
  return window == Window::kNarrow ? 0.5f : 0.0f;
}  ///< from the pixel, x and y
constexpr int kPatchSamples = 32;
constexpr int kPatchRadius = 5;
struct PatchOffsets {
  alignas(64) float dx[kPatchSamples];
  alignas(64) float dy[kPatchSamples];
};
const PatchOffsets& WindowOffsets();

/// The reference window of one pixel. Weights: exp(-|offset| / (2 * 5^2) - |grey - centre's grey| /
/// color_scale), zero outside the mask.
struct alignas(64) RefPatch {
  float weight[kPatchSamples];          ///< sum 1, or all zero
  float value[kPatchSamples];           ///< grey levels, minus the window's weighted mean
  float weighted_value[kPatchSamples];  ///< weight * value; sums to 0
  float variance = 0;                   ///< weighted, grey levels^2
  float noise_variance = 0;             ///< added to both variances of the correlation
  std::uint32_t unused = 0;             ///< bit k: sample k has no weight
};

/// exp(-|grey difference| / color_scale), tabulated.
struct BilateralTable {
  static constexpr int kSize = 1024;
  float similarity[kSize];
  /// @param color_scale  grey levels at which a sample's weight falls to 1/e
  explicit BilateralTable(float color_scale);
};

void FillRefPatch(const GreyMask& image, int x, int y, const BilateralTable& table,
                  float noise_variance, RefPatch* patch, Window window = Window::kWide);

/// A source image in a layout for sampling: one 64-bit read gives a pixel and its three neighbours
/// to the right and below.
///
/// Entry (x + 1, y + 1) belongs to pixel (x, y); the image has a border of one entry on all sides.
/// Low half: the pixel minus 32768, as int16, but its bit 0 is set if all four neighbours are in
/// the mask. High half: the same for the pixel below.
struct SampleImage {
  int width = 0, height = 0;  ///< with the border
  std::vector<std::uint32_t> entries;
};
SampleImage MakeSampleImage(const GreyMask& image);

/// Position of a plane's window in up to four sources, one per lane, in coordinates of SampleImage:
/// the sample (dx, dy) is at (x + (ax dx + bx dy) r, y + (ay dx + by dy) r) with r = 1 / (1 + ex dx
/// + ey dy). This form, relative to the centre, makes single precision accurate enough.
constexpr int kLanes = 4;
struct alignas(16) WarpLanes {
  float x[kLanes], y[kLanes], ax[kLanes], bx[kLanes], ay[kLanes], by[kLanes], ex[kLanes],
      ey[kLanes];
};

/// costs[k] = 1 - correlation for lanes first <= k < first + count, in [0, 2]; 2 when more than
/// half of the window's weight falls outside the source's mask or image. The cost of textureless
/// windows approaches 1, because the noise is added to both variances.
using PatchCostFunction = void (*)(const RefPatch& patch, const SampleImage* const* sources,
                                   const WarpLanes& warps, int first, int count, float* costs);

struct PatchCostKernel {
  std::string name;  ///< "scalar", "avx2", "avx512"
  PatchCostFunction cost;
};
/// Kernels that this processor supports, slowest first. The scalar one is the reference; the others
/// differ from it by at most 1e-4.
std::vector<PatchCostKernel> AvailablePatchCostKernels();
/// The last of them, unless KEYPOSE_SIMD names another.
const PatchCostKernel& BestPatchCostKernel();

constexpr float kWorstCost = 2.0f;

/// Weighted sums over the samples inside the source's mask: weight, reference and its square,
/// source and its square, product.
struct PatchSums {
  float w, r, rr, s, ss, rs;
};
float CostOfSums(const PatchSums& sums, float noise_variance);

/// The kernels for x86-64 that this processor supports; none elsewhere.
std::vector<PatchCostKernel> SimdPatchCostKernels();

}  // namespace keypose::stereo
