#include "capture/board/grey_level.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace keypose::capture::grey_level_test {

TEST(LevelAt, IsLinearBetweenPixelsAndClampedOutside) {
  cv::Mat ramp(3, 4, CV_8UC1);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x)
      ramp.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(10 * x + 40 * y);
  EXPECT_NEAR(LevelAt(ramp, 0.25, 1.5), 62.5, 1e-9);
  EXPECT_NEAR(LevelAt(ramp, 2, 1), 60, 1e-9);
  EXPECT_EQ(LevelAt(ramp, -5, -5), 0);
  EXPECT_NEAR(LevelAt(ramp, 100, 100), 110, 0.1);  // the clamp stops a thousandth of a pixel before
}

}  // namespace keypose::capture::grey_level_test
