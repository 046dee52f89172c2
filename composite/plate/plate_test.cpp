#include <gtest/gtest.h>

#include <cmath>

#include "composite/layer/linear_light.h"
#include "composite/plate/clean_plate.h"
#include "composite/plate/plate_between.h"
#include "core/values/errors.h"

namespace keypose::composite::plate_test {

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

/// A wall of soft spots that is moved to the left by `shift` pixels.
ImageF SpotsAt(double shift) {
  ImageF picture(160, 100, 3);
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 160; ++x) {
      const double u = x + shift;
      const double level = 120 + 45 * std::sin(0.21 * u + 0.6 * std::sin(0.13 * y)) +
                           40 * std::sin(0.17 * y + 0.11 * u);
      for (int c = 0; c < 3; ++c)
        picture.at(x, y)[c] = static_cast<float>(std::lround(level - 10 * c));
    }
  return picture;
}

TEST(PlateBetween, LiesOnTheWayOfTheCamera) {
  const PlateBetweenTwo between = PlateBetween(SpotsAt(0), SpotsAt(6), 0.25);
  const ImageF truth = SpotsAt(1.5), mixed = SpotsAt(0);
  const ImageF& mine = between.picture;
  double error = 0, unmoved = 0;
  int count = 0;
  for (int y = 12; y < 88; ++y)
    for (int x = 12; x < 148; ++x, ++count) {
      error += std::abs(mine.at(x, y)[1] - truth.at(x, y)[1]);
      unmoved += std::abs(mixed.at(x, y)[1] - truth.at(x, y)[1]);
    }
  EXPECT_LT(error / count, 2);
  EXPECT_GT(unmoved / count, 8) << "the test moves something";
  EXPECT_LT(between.doubtful, 0.05);
}

TEST(PlateBetween, WhatTheTwoDoNotShareIsCounted) {
  ImageF other = SpotsAt(0);
  for (int y = 30; y < 70; ++y)
    for (int x = 40; x < 80; ++x)
      for (int c = 0; c < 3; ++c) other.at(x, y)[c] = 255;
  EXPECT_GT(PlateBetween(SpotsAt(0), other, 0.5).doubtful, 0.05);
  EXPECT_THROW(PlateBetween(SpotsAt(0), ImageF(20, 20, 3), 0.5), InputError);
}

}  // namespace keypose::composite::plate_test
