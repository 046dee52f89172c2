#include "fit/bending/unfold.h"

#include <gtest/gtest.h>

#include "core/surfaces/shapes.h"

namespace keypose::fit::unfold_test {

TEST(Unfold, TurnsAFlippedFaceBackAndLeavesTheRest) {
  const Mesh sphere = MakeIcosphere(3);
  PointsX3 points = sphere.points;
  points.row(20) *= 0.2;  // pushed through its fan
  const PointsX3 before = points;
  const std::vector<Eigen::Matrix3d> maps(sphere.vertex_count(), Eigen::Matrix3d::Identity());
  const auto flipped = [&] { return FlippedFaces(sphere.points, sphere.faces, maps, points); };
  EXPECT_GT(flipped(), 2);
  const int moved = Unfold(sphere.points, sphere.faces, maps, points);
  EXPECT_EQ(flipped(), 0);
  EXPECT_GT(moved, 0);
  EXPECT_LT(moved, 60);
  EXPECT_LT((points.row(20) - sphere.points.row(20)).norm(), 0.05);
  int changed = 0;
  for (Eigen::Index v = 0; v < points.rows(); ++v) changed += points.row(v) != before.row(v);
  EXPECT_LE(changed, moved);
  PointsX3 good = sphere.points;
  EXPECT_EQ(Unfold(sphere.points, sphere.faces, maps, good), 0);
}

}  // namespace keypose::fit::unfold_test
