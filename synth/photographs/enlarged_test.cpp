#include "synth/photographs/enlarged.h"

#include <gtest/gtest.h>

namespace keypose::synth::enlarged_test {

TEST(Enlarged, StraightLinesStayStraight) {
  ImageF ramp(8, 6, 2);
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 8; ++x)
      ramp.at(x, y)[0] = static_cast<float>(2 * (x + 0.5) + (y + 0.5)), ramp.at(x, y)[1] = 3;
  const ImageF large = Enlarged(ramp, 3);
  ASSERT_EQ(large.width, 24);
  ASSERT_EQ(large.height, 18);
  for (int y = 6; y < 12; ++y)
    for (int x = 6; x < 18; ++x) {
      EXPECT_NEAR(large.at(x, y)[0], (2 * (x + 0.5) + (y + 0.5)) / 3, 1e-4);
      EXPECT_NEAR(large.at(x, y)[1], 3, 1e-5);
    }
  EXPECT_EQ(Enlarged(ramp, 1).data, ramp.data);
}

}  // namespace keypose::synth::enlarged_test
