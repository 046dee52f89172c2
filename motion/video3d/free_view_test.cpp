#include "motion/video3d/free_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/values/angles.h"
#include "core/values/errors.h"
#include "motion/testing/filmed_ball.h"

namespace keypose::motion::free_view_test {

using Eigen::Vector3d;

TEST(FreeView, OrbitKeepsTheActorInThePicture) {
  const BallWorld world(3);
  std::vector<Mesh> frames(20, world.mesh);
  for (int f = 0; f < 20; ++f) frames[f].points = world.Points(f);
  const std::vector<View> views = OrbitViews(frames, {});
  ASSERT_EQ(views.size(), 20u);
  for (int f = 0; f < 20; ++f)
    for (Eigen::Index v = 0; v < frames[f].points.rows(); v += 50) {
      const Eigen::Vector2d p = views[f].Project(frames[f].points.row(v));
      EXPECT_TRUE(p.x() > 0 && p.y() > 0 && p.x() < 960 && p.y() < 720) << f;
    }
  const Vector3d a = views[0].Center(), b = views[5].Center();
  EXPECT_LT(a.y(), -1) << "begins in front";
  EXPECT_GT(b.x(), 1) << "a quarter later it stands at the side";
}

TEST(FreeView, PathGoesThroughItsKeysAndStandsAtItsEnds) {
  const std::vector<CameraKey> keys =
      ParseCameraPath(R"({"keys": [{"frame": 2, "eye": [4, 0, 1], "look_at": [0, 0, 0]},
                                   {"frame": 6, "eye": [0, 4, 1], "look_at": [0, 0, 0]},
                                   {"frame": 8, "eye": [-4, 0, 1], "look_at": [0, 0, 1],
                                    "fov_deg": 60}]})",
                      "path.json");
  const std::vector<View> views = PathViews(keys, 12, {});
  EXPECT_LT((views[6].Center() - Vector3d(0, 4, 1)).norm(), 1e-9);
  EXPECT_LT((views[0].Center() - Vector3d(4, 0, 1)).norm(), 1e-9);
  EXPECT_LT((views[11].Center() - Vector3d(-4, 0, 1)).norm(), 1e-9);
  EXPECT_NEAR(views[11].camera.fy, 360 / std::tan(30 * kDegree), 1e-9);
  EXPECT_LT((views[4].Center() - views[3].Center()).norm(), 2.5);
}

TEST(FreeView, FaultsOfAPathAreNamed) {
  for (const char* text :
       {"[]", R"({"keys": []})", R"({"keys": [{"eye": [0, 0, 0], "look_at": [1, 0, 0]}]})",
        R"({"keys": [{"frame": 0, "eye": [0, 0], "look_at": [1, 0, 0]}]})",
        R"({"keys": [{"frame": 0, "eye": [0, 0, 0], "look_at": [1, 0, 0], "fov_deg": 200}]})",
        R"({"keys": [{"frame": 1, "eye": [0, 0, 0], "look_at": [1, 0, 0]},
                     {"frame": 1, "eye": [0, 0, 0], "look_at": [1, 0, 0]}]})"})
    EXPECT_THROW(ParseCameraPath(text, "path.json"), InputError) << text;
}

}  // namespace keypose::motion::free_view_test
