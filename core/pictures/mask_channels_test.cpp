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

TEST(AsLevels, KeepsTheNumbers) {
  const ImageF levels = AsLevels(Image8(2, 1, 1, 254));
  EXPECT_EQ(levels.width, 2);
  EXPECT_EQ(levels.data, std::vector<float>({254, 254}));
}

}  // namespace keypose::mask_channels_test
