#include "motion/video3d/camera_exposure.h"

#include <gtest/gtest.h>

#include <cmath>

namespace keypose::motion::camera_exposure_test {

using Eigen::Vector3f;

TEST(LevelExposures, FindsGainsAndIgnoresWhatDisagrees) {
  std::vector<ColorPair> pairs;
  for (int i = 0; i < 300; ++i) {
    const Vector3f color = Vector3f(0.2f, 0.3f, 0.25f) * (1 + 0.4f * std::sin(0.7f * i));
    // Camera 1 takes 1.2 times the light of camera 0; every tenth pair shows a highlight.
    pairs.push_back({0, 1, color, (i % 10 ? 1.2f : 2.6f) * color, 1});
  }
  const CameraExposures exposure = LevelExposures(pairs, 3);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(exposure.gains[0][c] / exposure.gains[1][c], 1.2, 0.012);
    EXPECT_NEAR(exposure.gains[0][c] * exposure.gains[1][c], 1, 1e-3);
    EXPECT_EQ(exposure.gains[2][c], 1);
  }
  EXPECT_TRUE(exposure.compared[0] && exposure.compared[1]);
  EXPECT_FALSE(exposure.compared[2]);
}

}  // namespace keypose::motion::camera_exposure_test
