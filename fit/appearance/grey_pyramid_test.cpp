#include "fit/appearance/grey_pyramid.h"

#include <gtest/gtest.h>

namespace keypose::fit::grey_pyramid_test {

TEST(MakeGreyPyramid, HalvesUntilASideGetsTooSmall) {
  const GreyPyramid pyramid = MakeGreyPyramid(Image8(64, 40, 3, 100), 9);
  ASSERT_EQ(pyramid.size(), 3u);
  for (int level = 0; level < 3; ++level) {
    EXPECT_EQ(pyramid[level].width, 64 >> level);
    EXPECT_EQ(pyramid[level].height, 40 >> level);
    for (const float grey : pyramid[level].data) ASSERT_NEAR(grey, 100, 1e-3);
  }
  EXPECT_EQ(MakeGreyPyramid(Image8(64, 40, 1), 2).size(), 2u);
}

TEST(MakeGreyPyramid, ALinearRampStaysLinear) {
  Image8 ramp(32, 32, 1);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) *ramp.at(x, y) = static_cast<std::uint8_t>(2 * x + 3 * y);
  const ImageF half = MakeGreyPyramid(ramp, 2).at(1);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) ASSERT_NEAR(*half.at(x, y), 4 * x + 6 * y + 2.5, 1e-4);
  EXPECT_NEAR(SampleGrey(half, 3.25, 7.5), 4 * 3.25 + 6 * 7.5 + 2.5, 1e-4);
}

TEST(SampleGrey, OutsideIsTheBordersValue) {
  ImageF image(2, 2, 1);
  image.data = {1, 2, 3, 4};
  EXPECT_EQ(SampleGrey(image, -4, -4), 1);
  EXPECT_EQ(SampleGrey(image, 9, -4), 2);
  EXPECT_EQ(SampleGrey(image, 9, 9), 4);
}

}  // namespace keypose::fit::grey_pyramid_test
