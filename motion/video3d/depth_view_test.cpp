#include "motion/video3d/depth_view.h"

#include <gtest/gtest.h>

#include "motion/video3d/testing/seen_ball.h"

namespace keypose::motion::depth_view_test {

using Eigen::Vector3d;

TEST(DepthView, NearestSurfaceCounts) {
  const Mesh scene = Joined(Wall(0, 0.5), Wall(-1, 0.1));
  const DepthView depth = MakeDepthView(scene.points, scene.faces, Straight(4, 200));
  EXPECT_NEAR(depth.At(100, 100), 1.0 / 3, 1e-6);  // the small wall, a metre nearer
  EXPECT_NEAR(depth.At(85, 100), 1.0 / 4, 1e-6);
  EXPECT_EQ(depth.box.x0 < 100 && depth.box.x1 < 130, true);
}

TEST(DepthView, MeshBehindTheCameraIsNotSeen) {
  const Mesh wall = Wall(0, 0.5);
  EXPECT_TRUE(MakeDepthView(wall.points, wall.faces, Straight(-4, 100)).box.empty() ||
              Straight(-4, 100).Center().y() > 0);
  View away = Straight(4, 100);
  away.camera_from_world = LookAt({0, -4, 0}, {0, -8, 0});
  EXPECT_TRUE(MakeDepthView(wall.points, wall.faces, away).box.empty());
}

}  // namespace keypose::motion::depth_view_test
