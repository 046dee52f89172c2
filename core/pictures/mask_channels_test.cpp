#include "core/pictures/mask_channels.h"

#include <gtest/gtest.h>

namespace keypose::mask_channels_test {

TEST(AlphaIsMask, WhereItDiffersOrHidesAll) {
  EXPECT_FALSE(AlphaIsMask({}));
  EXPECT_FALSE(AlphaIsMask(Image8(4, 3, 1, 255)));
  EXPECT_FALSE(AlphaIsMask(Image8(4, 3, 1, 128)));
  EXPECT_TRUE(AlphaIsMask(Image8(4, 3, 1)));
  Image8 differs(4, 3, 1, 255);
  differs.data.back() = 0;
  EXPECT_TRUE(AlphaIsMask(differs));
}

TEST(IsColoured, WhereAHundredthOfThePixelsIs) {
  ImageF rgb(20, 10, 3, 100);
  for (int p = 0; p < 200; ++p) rgb.data[3 * p] = 124;
  EXPECT_FALSE(IsColoured(rgb)) << "as a JPEG's noise colours grey";
  rgb.data[0] = 125;
  EXPECT_FALSE(IsColoured(rgb));
  rgb.data[3] = 125;
  EXPECT_TRUE(IsColoured(rgb)) << "2 of 200";
}

TEST(BrightestChannel, OfEachPixel) {
  ImageF rgb(2, 1, 3);
  rgb.data = {1, 200, 3, 90, 0, 0};
  const ImageF grey = BrightestChannel(rgb);
  EXPECT_EQ(grey.channels, 1);
  EXPECT_EQ(grey.data, std::vector<float>({200, 90}));
}

TEST(AsLevels, KeepsTheNumbers) {
  const ImageF levels = AsLevels(Image8(2, 1, 1, 254));
  EXPECT_EQ(levels.width, 2);
  EXPECT_EQ(levels.data, std::vector<float>({254, 254}));
}

}  // namespace keypose::mask_channels_test
