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

TEST(Grain, InLightOfAnyRangeItIsAsInLevels) {
  const ImageF clean = Ramp(320, 200);
  const Grain grain = GrainOf(3, 0);
  const ImageF light = LevelsOf(LightWithGrain(LinearOfLevels(clean), grain, {}, 1)),
               levels = WithGrain(clean, grain, {}, 1);
  for (std::size_t i = 0; i < levels.data.size(); ++i)
    ASSERT_NEAR(light.data[i], levels.data[i], 1e-3) << i;
}

TEST(Grain, LightWithoutAShareOfItStaysToTheBit) {
  ImageF light(4, 1, 3, 0.3f), share(4, 1, 1);
  light.data = {-0.25f, 0.1f, 7, 60000, -1e-4f, 0.5f, 2, 3, 4, 0, 0, 0};
  *share.at(3, 0) = 1;
  const ImageF with = LightWithGrain(light, GrainOf(5, 0), share, 3);
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(with.data[i], light.data[i]);
  EXPECT_NE(with.data[9], 0) << "what lacks it gets it";
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
