#include "composite/light/grain.h"

#include <gtest/gtest.h>

#include <random>

#include "composite/layer/linear_light.h"

namespace keypose::composite::grain_test {

/// A picture with all levels between 30 and 220.
ImageF Ramp(int width, int height) {
  ImageF ramp(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        ramp.at(x, y)[c] = 30 + 190.0f * static_cast<float>((x + 13 * c) % width) / width;
  return ramp;
}

Grain GrainOf(double sigma, double neighbours) {
  Grain grain;
  for (auto& channel : grain.sigma) channel.fill(sigma);
  grain.neighbours = neighbours;
  return grain;
}

TEST(Grain, MadeGrainMeasuresTheSame) {
  const ImageF clean = Ramp(320, 200);
  for (const double sigma : {1.0, 3.0, 6.0})
    for (const double neighbours : {0.0, 0.4}) {
      const Grain grain = GrainOf(sigma, neighbours);
      const Image8 a = Rounded(WithGrain(clean, grain, {}, 1)),
                   b = Rounded(WithGrain(clean, grain, {}, 2));
      const auto measured = MeasureGrain(a, b, {});
      ASSERT_TRUE(measured);
      EXPECT_NEAR(measured->MeanSigma(), sigma, 0.1 * sigma + 0.1);
      EXPECT_NEAR(measured->neighbours, neighbours, 0.08) << sigma;
    }
}

TEST(Grain, WhatMovedIsNotGrain) {
  const ImageF clean = Ramp(320, 200);
  const Grain grain = GrainOf(2, 0);
  const Image8 a = Rounded(WithGrain(clean, grain, {}, 1));
  Image8 b = Rounded(WithGrain(clean, grain, {}, 2));
  std::mt19937 random(5);
  for (int y = 40; y < 120; ++y)
    for (int x = 60; x < 160; ++x)
      for (int c = 0; c < 3; ++c) b.at(x, y)[c] = static_cast<std::uint8_t>(random() % 250);
  EXPECT_NEAR(MeasureGrain(a, b, {})->MeanSigma(), 2, 0.7);
}

TEST(Grain, SeedAndShareDecide) {
  const ImageF clean = Ramp(80, 50);
  const Grain grain = GrainOf(4, 0.2);
  EXPECT_EQ(WithGrain(clean, grain, {}, 7).data, WithGrain(clean, grain, {}, 7).data);
  EXPECT_NE(WithGrain(clean, grain, {}, 7).data, WithGrain(clean, grain, {}, 8).data);
  const ImageF none(80, 50, 1, 0.0f);
  EXPECT_EQ(WithGrain(clean, grain, none, 7).data, clean.data) << "fractions of a level stay";
  EXPECT_FALSE(MeasureGrain(Image8(20, 20, 3, 100), Image8(20, 20, 3, 100), {}));
}

}  // namespace keypose::composite::grain_test
