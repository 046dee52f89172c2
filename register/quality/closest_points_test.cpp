#include "register/quality/closest_points.h"

#include <gtest/gtest.h>

#include <random>

#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"

namespace keypose::registration::closest_points_test {

PointsX3 Scattered(int count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-2, 2);
  PointsX3 points(count, 3);
  for (int i = 0; i < count; ++i)
    for (int c = 0; c < 3; ++c) points(i, c) = unit(random);
  return points;
}

TEST(ClosestPoints, AreThoseOfEachPointAskedByItself) {
  const Mesh box = MakeBox(1, 1, 1);
  const RayScene scene(box.points, box.faces);
  const PointsX3 points = Scattered(1000);
  const auto feet = ClosestPoints(scene, points);
  ASSERT_EQ(feet.size(), 1000u);
  for (int i = 0; i < 1000; ++i)
    EXPECT_NEAR(feet[i].squared_distance, scene.ClosestPoint(points.row(i)).squared_distance,
                1e-12);
}

TEST(ClosestPoints, SameBitsForAnyThreadCount) {
  const Mesh ball = MakeIcosphere(3);
  const RayScene scene(ball.points, ball.faces);
  const PointsX3 points = Scattered(2000);
  SetThreadCount(1);
  const auto one = ClosestPoints(scene, points);
  SetThreadCount(3);
  const auto three = ClosestPoints(scene, points);
  SetThreadCount(0);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].face, three[i].face);
    EXPECT_EQ(one[i].squared_distance, three[i].squared_distance);
  }
}

}  // namespace keypose::registration::closest_points_test
