#include "fit/cameras/find_cameras.h"

#include <gtest/gtest.h>

namespace keypose::fit::find_cameras_test {

FoundCamera WithInliers(int inliers) {
  FoundCamera camera;
  camera.found = true;
  camera.inliers = inliers;
  camera.matches.resize(100);
  return camera;
}

TEST(KeepSureCameras, LeavesOutWhatFewMatchesAgreeWith) {
  std::vector<FoundCamera> cameras = {WithInliers(50), WithInliers(20), WithInliers(37),
                                      WithInliers(69)};
  EXPECT_TRUE(KeepSureCameras(cameras));
  EXPECT_TRUE(cameras[0].found && cameras[2].found && cameras[3].found);
  EXPECT_FALSE(cameras[1].found);
  EXPECT_FALSE(KeepSureCameras(cameras)) << "nothing is left to leave out";
}

TEST(KeepSureCameras, LeavesAllWhereTooFewAreSure) {
  std::vector<FoundCamera> cameras = {WithInliers(50), WithInliers(20), WithInliers(14),
                                      WithInliers(69)};
  EXPECT_FALSE(KeepSureCameras(cameras));
  for (const FoundCamera& camera : cameras) EXPECT_TRUE(camera.found);
}

}  // namespace keypose::fit::find_cameras_test
