#include "composite/locating/outline/outline_matches.h"

#include <gtest/gtest.h>

#include <cmath>

namespace keypose::composite::outline_matches_test {

constexpr double kMiddle = 100;

Image8 Disc(double radius) {
  Image8 matte(200, 200, 1);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x)
      if (std::hypot(x + 0.5 - kMiddle, y + 0.5 - kMiddle) < radius) *matte.at(x, y) = 255;
  return matte;
}

std::vector<SilhouettePoint> Circle(double radius) {
  std::vector<SilhouettePoint> points(360);
  for (int k = 0; k < 360; ++k) {
    const double angle = k * EIGEN_PI / 180;
    SilhouettePoint& point = points[k];
    point.normal = {std::cos(angle), std::sin(angle)};
    point.pixel = Eigen::Vector2d::Constant(kMiddle) + radius * point.normal;
    point.position << point.pixel, 1;
    point.length_px = radius * EIGEN_PI / 180;
  }
  return points;
}

TEST(MatchOutlines, ALargerMatteLiesOutwardsAllRoundInBothDirections) {
  const OutlineMatches found = MatchOutlines(Circle(50), MatteOutline(Disc(53)), 10);
  EXPECT_EQ(found.unmatched_px, 0);
  for (const OutlineMatch& match : found.matches) ASSERT_NEAR(match.distance_px, 3, 0.8);
  EXPECT_NEAR(found.MeanMatched(), 3, 0.2);
  EXPECT_NEAR(found.Mean(10), found.MeanMatched(), 1e-9);
}

TEST(MatchOutlines, WhatIsFartherThanTheReachHasNoPartner) {
  const OutlineMatches found = MatchOutlines(Circle(50), MatteOutline(Disc(70)), 10);
  EXPECT_TRUE(found.matches.empty());
  EXPECT_NEAR(found.unmatched_px, found.length_px, 1e-6);
  EXPECT_NEAR(found.Mean(10), 10, 1e-9);
}

TEST(MatchOutlines, InnerOutlinesDoNotCount) {
  std::vector<SilhouettePoint> inner = Circle(50);
  for (SilhouettePoint& point : inner) point.inner = true;
  EXPECT_TRUE(MatchOutlines(inner, MatteOutline(Disc(50)), 10).matches.empty());
}

}  // namespace keypose::composite::outline_matches_test
