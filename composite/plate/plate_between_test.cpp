#include "composite/plate/plate_between.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/values/errors.h"

namespace keypose::composite::plate_between_test {

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

}  // namespace keypose::composite::plate_between_test
