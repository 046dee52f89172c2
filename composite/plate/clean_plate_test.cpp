#include "composite/plate/clean_plate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/values/errors.h"

namespace keypose::composite::clean_plate_test {

constexpr int kWidth = 60, kHeight = 40;

float SetLight(int x, int y) {
  return 0.2f + 0.1f * std::sin(0.3f * x) + 0.05f * std::cos(0.4f * y);
}

/// The set with a block in front of it, from column `from` to `to`, that takes light on its right.
PlateFrame FrameWith(int from, int to, float shadow = 1) {
  PlateFrame frame{ImageF(kWidth, kHeight, 3), Image8(kWidth, kHeight, 1), {}};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const bool covered = x >= from && x < to && y >= 10 && y < 30;
      const bool dark = x >= to && x < to + 10;
      for (int c = 0; c < 3; ++c)
        frame.light.at(x, y)[c] = covered ? 0.9f : SetLight(x, y) * (dark ? shadow : 1);
      *frame.away.at(x, y) = covered ? 255 : 0;
    }
  return frame;
}

double WorstOf(const CleanPlate& plate, int from = 0, int to = kWidth) {
  double worst = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = from; x < to; ++x)
      worst =
          std::max(worst, static_cast<double>(std::abs(plate.light.at(x, y)[1] - SetLight(x, y))));
  return worst;
}

TEST(CleanPlate, WhatMovesAwayIsGone) {
  const CleanPlate plate =
      MakeCleanPlate({FrameWith(5, 15), FrameWith(20, 30), FrameWith(40, 50)}, {});
  EXPECT_EQ(plate.hidden, 0);
  EXPECT_LT(WorstOf(plate), 1e-4);
  EXPECT_NEAR(*plate.grain_lacking.at(2, 2), 2.0 / 3, 1e-6);
  EXPECT_NEAR(*plate.grain_lacking.at(7, 15), 0.5, 1e-6);
}

TEST(CleanPlate, ShadowsDoNotDarkenIt) {
  const CleanPlate plate =
      MakeCleanPlate({FrameWith(2, 8, 0.5f), FrameWith(22, 28, 0.5f), FrameWith(42, 48, 0.5f)}, {});
  EXPECT_LT(WorstOf(plate), 1e-4);
}

TEST(CleanPlate, KnownShadowsAreUndone) {
  // The shadow lies at the same place in all frames; only knowing it helps.
  std::vector<PlateFrame> frames{FrameWith(5, 15, 0.6f), FrameWith(5, 15, 0.6f)};
  for (PlateFrame& frame : frames) {
    frame.kept = ImageF(kWidth, kHeight, 1, 1.0f);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 15; x < 25; ++x) *frame.kept.at(x, y) = 0.6f;
  }
  EXPECT_LT(WorstOf(MakeCleanPlate(frames, {}), 15), 1e-4);
}

TEST(CleanPlate, WhatStaysHiddenIsCountedAndPaintedOrTakenFromAGivenPlate) {
  const std::vector<PlateFrame> frames{FrameWith(20, 30), FrameWith(24, 34)};
  const CleanPlate painted = MakeCleanPlate(frames, {});
  EXPECT_EQ(painted.hidden, 6 * 20);
  EXPECT_EQ(painted.inpainted, 6 * 20);
  EXPECT_LT(WorstOf(painted), 0.12) << "smooth surroundings are continued";
  const ImageF given = FrameWith(0, 0).light;
  const CleanPlate taken = MakeCleanPlate(frames, given);
  EXPECT_EQ(taken.given, 6 * 20);
  EXPECT_EQ(taken.inpainted, 0);
  EXPECT_LT(WorstOf(taken), 1e-4);
  EXPECT_EQ(*taken.grain_lacking.at(26, 20), 0) << "it has grain of its own";
}

TEST(CleanPlate, BadInputIsRefused) {
  EXPECT_THROW(MakeCleanPlate({}, {}), InputError);
  PlateFrame other = FrameWith(0, 0);
  other.light = ImageF(10, 10, 3);
  EXPECT_THROW(MakeCleanPlate({FrameWith(0, 0), other}, {}), InputError);
  EXPECT_THROW(MakeCleanPlate({FrameWith(0, 0)}, ImageF(10, 10, 3)), InputError);
}

}  // namespace keypose::composite::clean_plate_test
