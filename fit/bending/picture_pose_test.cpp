#include <gtest/gtest.h>

#include <random>

#include "core/pictures/fit_view.h"
#include "fit/bending/testing/turned_ring.h"
#include "views/placement/picture_pose.h"

namespace keypose::fit::picture_pose_test {

TEST(PlacePicture, FindsTheCameraAmongOutliers) {
  const PointsX3 points = Patch();
  const Rigid3 pose = LookAt({1, -3, 5}, {0, 0, 0});
  const PicturePose found = PlacePicture(kCamera, points, PlaneMatches(points, pose), 6, 12);
  ASSERT_TRUE(found.found);
  EXPECT_LT(found.camera_from_world.rotation.angularDistance(pose.rotation), 1e-3);
  EXPECT_LT((found.camera_from_world.Inverse().translation - pose.Inverse().translation).norm(),
            5e-3);
  EXPECT_GE(found.inliers.size(), 320u);
}

TEST(PlacePicture, FindsNothingInNoise) {
  const PointsX3 points = Patch();
  std::vector<FeatureMatch> matches = PlaneMatches(points, LookAt({1, -3, 5}, {0, 0, 0}));
  std::mt19937 random(3);
  for (FeatureMatch& match : matches) match.pixel = Eigen::Vector2d(random() % 800, random() % 800);
  EXPECT_FALSE(PlacePicture(kCamera, points, matches, 6, 12).found);
}

}  // namespace keypose::fit::picture_pose_test
