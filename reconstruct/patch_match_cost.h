// The photometric cost of a plane hypothesis: one minus the bilaterally weighted correlation of a window in two photographs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "reconstruct/dense_view.h"

namespace keypose::reconstruct {

/// Window: 11 x 11 with step 2 and without its corners, so that 32 samples fill four AVX2 or two AVX-512 registers.
constexpr int kPatchSamples = 32;
constexpr int kPatchRadius = 5;
struct PatchOffsets {
  alignas(64) float dx[kPatchSamples];
  alignas(64) float dy[kPatchSamples];
};
const PatchOffsets& WindowOffsets();

/// The reference window of one pixel. Weights: exp(-|offset| / (2 * 5^2) - |grey - centre's grey| / color_scale), zero outside the mask.
struct alignas(64) RefPatch {
  float weight[kPatchSamples];
  float value[kPatchSamples];  ///< grey levels, less `offset`
  float offset = 0;            ///< weighted mean grey of the window; subtracted from both images to keep single precision exact enough
  float weight_sum = 0;
  float variance = 0;  ///< weighted, grey levels^2
};

/// exp(-|grey difference| / color_scale), tabulated.
struct BilateralTable {
  static constexpr int kSize = 1024;
  float similarity[kSize];
  /// @param color_scale  grey levels at which a sample's weight falls to 1/e
  explicit BilateralTable(float color_scale);
};

void FillRefPatch(const GreyMask& image, int x, int y, const BilateralTable& table, RefPatch* patch);

/// Where the window's sample (dx, dy) lies in the source image: h0 + dx hx + dy hy, divided by its third coordinate.
struct PatchWarp {
  float h0[3], hx[3], hy[3];
};

/// 1 - correlation, in [0, 2]; 2 when more than half of the window's weight falls outside the source's mask or image.
/// Textureless windows tend to 1 because `noise_variance` is added to both variances.
///
/// @param source  at least 2 x 2 pixels
using PatchCostFunction = float (*)(const RefPatch& patch, const GreyMask& source, const PatchWarp& warp, float noise_variance);

struct PatchCostKernel {
  std::string name;  ///< "scalar", "avx2", "avx512"
  PatchCostFunction cost;
};
/// Kernels that this processor runs, slowest first. The scalar one is the reference; the others agree to 1e-4.
std::vector<PatchCostKernel> AvailablePatchCostKernels();
/// The last of them, unless KEYPOSE_SIMD names another.
const PatchCostKernel& BestPatchCostKernel();

constexpr float kWorstCost = 2.0f;

}  // namespace keypose::reconstruct
