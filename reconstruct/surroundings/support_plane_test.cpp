#include "reconstruct/surroundings/support_plane.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/values/errors.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::support_plane_test {

using Eigen::Vector3d;

/// A figure of height 1 on a tilted table of the given points, and a wall behind it; the camera
/// goes round `arc` of a circle at 4 units, aiming at the figure's middle.
Scene RoomScene(int table_points, double arc, const Eigen::Quaterniond& tilt) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> gauss(0, 0.002);
  Scene scene;
  Camera camera;
  camera.width = 1200, camera.height = 900;
  camera.fx = camera.fy = 1200, camera.cx = 600, camera.cy = 450;
  for (int k = 0; k < 16; ++k) {
    const double angle = arc * k / 16;
    const Vector3d eye(4 * std::sin(angle), -4 * std::cos(angle), 1.5 + 0.8 * (k % 3));
    View view = testing::LookFrom(eye - Vector3d(0, 0, 0.5), camera, std::to_string(k));
    // LookFrom aims at the origin; the figure's middle is at height 0.5.
    view.camera_from_world =
        Compose(view.camera_from_world, Rigid3{Eigen::Quaterniond::Identity(), {0, 0, -0.5}});
    view.camera_from_world =
        Compose(view.camera_from_world, Rigid3{tilt.conjugate(), Vector3d::Zero()});
    scene.views.push_back(view);
  }
  const auto add = [&](const Vector3d& x) { scene.points.push_back(testing::PointAt(tilt * x)); };
  for (int p = 0; p < table_points; ++p) add({2 * unit(random), 2 * unit(random), gauss(random)});
  for (int p = 0; p < 300; ++p)
    add({0.3 * unit(random), 0.3 * unit(random), 0.5 + 0.5 * unit(random)});
  for (int p = 0; p < 600; ++p) add({4 * unit(random), 3.5, 2 + 2 * unit(random)});
  return scene;
}

TEST(FindSupportPlane, TableUnderTheFigureNotTheWallBehind) {
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.4, Vector3d(1, 0.3, -0.2).normalized()));
  const auto plane = FindSupportPlane(RoomScene(400, 1.6, tilt));
  ASSERT_TRUE(plane);
  EXPECT_GT(plane->normal.dot(tilt * Vector3d::UnitZ()), std::cos(0.005));
  EXPECT_NEAR(plane->offset, 0, 0.01);
  EXPECT_NEAR(plane->distance, 4.2, 0.4);
  EXPECT_LT(plane->foot.norm(), 0.1);
}

TEST(FindSupportPlane, NothingUnderAFigureOnPlainCloth) {
  EXPECT_FALSE(FindSupportPlane(RoomScene(0, 6.28, Eigen::Quaterniond::Identity())));
}

TEST(LookedAt, OneViewThrows) {
  Scene scene = RoomScene(0, 1, Eigen::Quaterniond::Identity());
  scene.views.resize(1);
  EXPECT_THROW(LookedAt(scene.views), InputError);
}

// One camera of sixteen that looks elsewhere does not move what the others look at.
TEST(LookedAt, OneStrayViewHasLittleWeight) {
  Scene scene = RoomScene(0, 6.28, Eigen::Quaterniond::Identity());
  const Rigid3 aside{Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vector3d::UnitY())),
                     Vector3d::Zero()};
  scene.views[3].camera_from_world = Compose(aside, scene.views[3].camera_from_world);
  EXPECT_LT((LookedAt(scene.views) - Vector3d(0, 0, 0.5)).norm(), 0.02);
}

}  // namespace keypose::reconstruct::support_plane_test
