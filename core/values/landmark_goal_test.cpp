#include "core/values/landmark_goal.h"

#include <gtest/gtest.h>

namespace keypose::landmark_goal_test {

TEST(PositionOf, IsTheWeightedMeanOfItsVertices) {
  PointsX3 points(3, 3);
  points << 0, 0, 0, 4, 0, 0, 0, 8, 0;
  const SurfacePoint point{{0, 1, 2}, {0.25, 0.5, 0.25}};
  EXPECT_EQ(PositionOf(point, points), Eigen::Vector3d(2, 2, 0));
}

TEST(PositionOf, ByDefaultIsTheFirstVertex) {
  PointsX3 points(1, 3);
  points << 1, 2, 3;
  EXPECT_EQ(PositionOf(SurfacePoint(), points), Eigen::Vector3d(1, 2, 3));
}

}  // namespace keypose::landmark_goal_test
