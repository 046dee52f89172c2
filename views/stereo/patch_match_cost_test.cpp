#include "views/stereo/patch_match_cost.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "views/stereo/patch_match_warp.h"

namespace keypose::stereo::patch_match_cost_test {

GreyMask NoiseImage(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  GreyMask image(width, height, 1);
  for (std::uint16_t& pixel : image.data)
    pixel = static_cast<std::uint16_t>((random() & 0xFFFE) | 1);
  return image;
}

// The same picture blurred, so that bilinear sampling is accurate.
GreyMask SmoothImage(int width, int height, double phase_x, double phase_y) {
  GreyMask image(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double u = x + phase_x, v = y + phase_y;
      const double grey = 128 + 40 * std::sin(0.31 * u + 0.11 * v) +
                          30 * std::sin(0.07 * u - 0.36 * v) +
                          20 * std::sin(0.2 * u * 0.9 + 0.23 * v);
      *image.at(x, y) = static_cast<std::uint16_t>(std::lround(grey * 32767 / 255)) << 1 | 1;
    }
  return image;
}

// A homography by its columns at the window's centre: the image of the centre, and the change for a
// step in x and in y.
struct Warp {
  float h0[3], hx[3], hy[3];
};
Warp Shift(float x, float y) { return {{x, y, 1}, {1, 0, 0}, {0, 1, 0}}; }

// In the first lane; the others are shifted by their index, so that mixed-up lanes are detected.
WarpLanes Lanes(const Warp& warp, Window window = Window::kWide) {
  TransferLanes transfers;
  for (int lane = 0; lane < kLanes; ++lane) {
    Transfer transfer;
    for (int i = 0; i < 3; ++i)
      transfer.a(i, 0) = warp.hx[i], transfer.a(i, 1) = warp.hy[i], transfer.a(i, 2) = warp.h0[i];
    transfer.a.row(0) += static_cast<float>(lane) * transfer.a.row(2);
    transfer.b.setZero();
    transfers.Set(lane, transfer);
  }
  return WarpsOf(transfers, AtPixel(transfers, WindowMiddle(window), WindowMiddle(window)), {},
                 WindowScale(window));
}

float Cost(const PatchCostKernel& kernel, const RefPatch& patch, const GreyMask& source,
           const Warp& warp, Window window = Window::kWide) {
  const SampleImage samples = MakeSampleImage(source);
  const SampleImage* sources[kLanes] = {&samples, &samples, &samples, &samples};
  float costs[kLanes];
  kernel.cost(patch, sources, Lanes(warp, window), 0, 1, costs);
  return costs[0];
}

TEST(PatchCost, ExactTranslationCostsNothing) {
  const GreyMask image = NoiseImage(64, 64, 1);
  GreyMask moved(64, 64, 1, 1);
  for (int y = 3; y < 64; ++y)
    for (int x = 0; x < 57; ++x) *moved.at(x, y) = *image.at(x + 7, y - 3);
  RefPatch patch;
  for (const Window window : {Window::kWide, Window::kNarrow}) {
    FillRefPatch(image, 30, 30, BilateralTable(18), 0, &patch, window);
    for (const PatchCostKernel& kernel : AvailablePatchCostKernels())
      EXPECT_LT(Cost(kernel, patch, moved, Shift(23, 33), window), 1e-6f) << kernel.name;
  }
}

// Six by six pixels without their corners, from two to the left and above to three to the right and
// below.
TEST(PatchCost, NarrowWindowSeesItsOwnPixelsAndNoOthers) {
  const GreyMask image = NoiseImage(64, 64, 9);
  RefPatch before, after;
  FillRefPatch(image, 30, 30, BilateralTable(1000), 0, &before, Window::kNarrow);
  int affected = 0;
  for (int y = 22; y < 40; ++y)
    for (int x = 22; x < 40; ++x) {
      GreyMask changed = image;
      *changed.at(x, y) ^= 0x4000;
      FillRefPatch(changed, 30, 30, BilateralTable(1000), 0, &after, Window::kNarrow);
      const int dx = x - 30, dy = y - 30;
      const bool inside = dx >= -2 && dx <= 3 && dy >= -2 && dy <= 3,
                 corner = (dx == -2 || dx == 3) && (dy == -2 || dy == 3);
      // The other samples are weighted relative to the pixel itself.
      ASSERT_EQ(before.variance != after.variance, inside && !corner) << dx << ' ' << dy;
      affected += before.variance != after.variance;
    }
  EXPECT_EQ(affected, kPatchSamples);
}

TEST(PatchCost, GainAndOffsetOfTheSourceDoNotMatter) {
  const GreyMask image = SmoothImage(64, 64, 0, 0);
  GreyMask darker = image;
  for (std::uint16_t& pixel : darker.data)
    pixel = static_cast<std::uint16_t>(((pixel >> 1) / 2 + 3000) << 1 | 1);
  RefPatch patch;
  FillRefPatch(image, 30, 30, BilateralTable(18), 0, &patch);
  EXPECT_LT(Cost(BestPatchCostKernel(), patch, darker, Shift(30, 30)), 1e-5f);
}

TEST(PatchCost, SlantedPlaneWarpOfSmoothTextureCostsLittleAndWrongPlaneMuch) {
  const GreyMask image = SmoothImage(80, 80, 0, 0);
  // source(x', y') = image(x, y) with x' = 0.8 x + 6.3, y' = y + 0.1 x + 1.2: an oblique view of a
  // plane.
  GreyMask source(80, 80, 1);
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 80; ++x) {
      const double u = (x - 6.3) / 0.8, v = y - 0.1 * u - 1.2;
      const double grey = 128 + 40 * std::sin(0.31 * u + 0.11 * v) +
                          30 * std::sin(0.07 * u - 0.36 * v) +
                          20 * std::sin(0.2 * u * 0.9 + 0.23 * v);
      *source.at(x, y) = static_cast<std::uint16_t>(std::lround(grey * 32767 / 255)) << 1 | 1;
    }
  RefPatch patch;
  FillRefPatch(image, 40, 40, BilateralTable(1000), 0, &patch);
  const Warp warp{{0.8f * 40 + 6.3f, 40 + 4.0f + 1.2f, 1}, {0.8f, 0.1f, 0}, {0, 1, 0}};
  Warp wrong = warp;
  wrong.h0[0] += 6;
  EXPECT_LT(Cost(BestPatchCostKernel(), patch, source, warp), 1e-3f);
  EXPECT_GT(Cost(BestPatchCostKernel(), patch, source, wrong), 0.2f);
}

TEST(PatchCost, KernelsAgreeOnRandomWarpsToOneInTenThousand) {
  const GreyMask image = NoiseImage(96, 80, 2);
  GreyMask source = NoiseImage(96, 80, 3);
  for (int y = 0; y < 80; ++y)  // a mask with a ragged border
    for (int x = 0; x < 96; ++x)
      if (x + (y * 7) % 5 < 20) *source.at(x, y) &= 0xFFFE;
  const SampleImage samples = MakeSampleImage(source);
  const SampleImage* sources[kLanes] = {&samples, &samples, &samples, &samples};
  const std::vector<PatchCostKernel> kernels = AvailablePatchCostKernels();
  std::mt19937 random(4);
  std::uniform_real_distribution<float> unit(-1, 1);
  RefPatch patch;
  int partial = 0;
  const BilateralTable table(60);
  for (int trial = 0; trial < 8000; ++trial) {
    const Window window = trial % 3 ? Window::kWide : Window::kNarrow;
    FillRefPatch(image, static_cast<int>(random() % 96), static_cast<int>(random() % 80), table,
                 0.5f, &patch, window);
    Warp warp{{48 + 60 * unit(random), 40 + 50 * unit(random), 1},
              {1 + 0.5f * unit(random), 0.5f * unit(random), 0.01f * unit(random)},
              {0.5f * unit(random), 1 + 0.5f * unit(random), 0.01f * unit(random)}};
    if (trial % 50 == 0)
      warp.h0[2] = trial % 100 ? -1.0f : 0.0f;  // behind the camera, and in its plane
    const int first = trial % 2, count = 1 + trial % (kLanes - 1);
    float reference[kLanes], costs[kLanes];
    kernels[0].cost(patch, sources, Lanes(warp, window), first, count, reference);
    for (int k = first; k < first + count; ++k) {
      ASSERT_TRUE(reference[k] >= 0 && reference[k] <= kWorstCost);
      partial += reference[k] < kWorstCost;
    }
    for (const PatchCostKernel& kernel : kernels) {
      kernel.cost(patch, sources, Lanes(warp, window), first, count, costs);
      for (int k = first; k < first + count; ++k)
        ASSERT_NEAR(costs[k], reference[k], 1e-4f) << kernel.name << " trial " << trial;
    }
  }
  EXPECT_GT(partial, 4000);
}

TEST(PatchCost, WindowMostlyOutsideTheSourceMaskIsWorst) {
  const GreyMask image = NoiseImage(64, 64, 5);
  GreyMask source = image;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      if (x < 32) *source.at(x, y) &= 0xFFFE;
  RefPatch patch;
  FillRefPatch(image, 30, 30, BilateralTable(1000), 0, &patch);
  EXPECT_EQ(Cost(BestPatchCostKernel(), patch, source, Shift(30, 30)), kWorstCost);
  FillRefPatch(image, 36, 30, BilateralTable(1000), 0, &patch);
  EXPECT_LT(Cost(BestPatchCostKernel(), patch, source, Shift(36, 30)), 0.1f);
}

TEST(PatchCost, FlatWindowsWithNoiseTellNothing) {
  GreyMask flat(64, 64, 1), other = flat;
  std::mt19937 random(6);
  for (std::size_t i = 0; i < flat.data.size(); ++i) {
    flat.data[i] = static_cast<std::uint16_t>((16000 + random() % 64) << 1 |
                                              1);  // about a quarter of a grey level
    other.data[i] = static_cast<std::uint16_t>((16000 + random() % 64) << 1 | 1);
  }
  RefPatch patch;
  FillRefPatch(flat, 30, 30, BilateralTable(18), 0.36f, &patch);
  for (int shift = -8; shift <= 8; ++shift)
    EXPECT_NEAR(Cost(BestPatchCostKernel(), patch, other, Shift(30.0f + shift, 30)), 1, 0.1);
  EXPECT_GT(Cost(BestPatchCostKernel(), patch, flat, Shift(30, 30)), 0.7f)
      << "even a perfect match of noise must not convince";
}

}  // namespace keypose::stereo::patch_match_cost_test
