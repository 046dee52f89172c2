#include "armature/example/theropod_set.h"

#include <gtest/gtest.h>

#include <cmath>

namespace keypose::armature::theropod_set_test {

TEST(MakeTheropodSet, TableTopIsTheGround) {
  const Mesh set = MakeTheropodSet();
  EXPECT_EQ(set.colors.rows(), set.points.rows());
  EXPECT_NEAR(set.points.col(2).minCoeff(), -0.04, 1e-12);  // below: the planks alone
  int on_the_ground = 0;
  for (Eigen::Index v = 0; v < set.points.rows(); ++v)
    on_the_ground += std::abs(set.points(v, 2)) < 1e-12;
  EXPECT_GE(on_the_ground, 4 * 6);
}

TEST(MakeTheropodShot, AStillCameraLooksAtTheMiddleOfTheTable) {
  const FilmedShot shot = MakeTheropodShot(160, 90, 3);
  ASSERT_EQ(shot.frames.size(), 3u);
  for (int f = 0; f < 3; ++f) EXPECT_EQ(shot.frames[f].frame, f);
  const Eigen::Vector3d aim = shot.frames[2].camera_from_world * Eigen::Vector3d(0, 0.02, 0.2);
  EXPECT_NEAR(aim.head<2>().norm(), 0, 1e-12);
  EXPECT_GT(aim.z(), 0);
  EXPECT_EQ(shot.frames[0].camera_from_world.translation,
            shot.frames[2].camera_from_world.translation);
}

TEST(MakeTheropodPlate, ShowsTheSetInTheShotsSize) {
  const FilmedShot shot = MakeTheropodShot(160, 90, 1);
  const Image8 plate = MakeTheropodPlate(shot);
  ASSERT_EQ(plate.width, 160);
  ASSERT_EQ(plate.height, 90);
  ASSERT_EQ(plate.channels, 3);
  // Wood at the bottom is warm: its red is above its blue by far.
  const auto* bottom = plate.data.data() + 3 * (85 * 160 + 80);
  EXPECT_GT(bottom[0], bottom[2] + 20);
}

}  // namespace keypose::armature::theropod_set_test
