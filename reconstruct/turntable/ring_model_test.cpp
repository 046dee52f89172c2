#include "reconstruct/turntable/ring_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::reconstruct::ring_model_test {

using ::testing::ElementsAre;

TEST(LayoutOfAngles, PutsPhotographsOnTheirRingsAtTheirAngles) {
  const auto layout = LayoutOfAngles({2, 1, 1, 2, 1, 2, 1}, {0, 30, 0, 120, 15, 240, 345});
  ASSERT_TRUE(layout);
  ASSERT_EQ(layout->rings.size(), 2u);
  EXPECT_EQ(layout->positions, (std::vector<int>{24, 3}));
  const int images[] = {2, 4, 1, 6}, index[] = {0, 1, 2, 23};
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(layout->rings[0][k].image, images[k]);
    EXPECT_DOUBLE_EQ(layout->rings[0][k].index, index[k]);
  }
  EXPECT_DOUBLE_EQ(layout->rings[1][2].index, 2);
}

TEST(LayoutOfAngles, OfTwoPhotographsOrOfEqualAnglesIsNothing) {
  EXPECT_FALSE(LayoutOfAngles({1, 1}, {0, 90}));
  EXPECT_FALSE(LayoutOfAngles({1, 1, 1, 2}, {0, 90, 180, 0}));
  EXPECT_FALSE(LayoutOfAngles({1, 1, 1}, {0, 90, 90}));
}

TEST(LikelyLayouts, NumbersInNamesTellTheGaps) {
  const auto layouts =
      LikelyLayouts({"a0007.jpg", "a0008.jpg", "a0010.jpg", "a0011.jpg", "a0012.jpg", "a0014.jpg"});
  ASSERT_EQ(layouts.size(), 2U);
  EXPECT_THAT(layouts[0].positions, ElementsAre(8));
  EXPECT_EQ(layouts[0].rings[0][2].index, 3);
  EXPECT_THAT(layouts[1].positions, ElementsAre(4, 4));
  EXPECT_EQ(layouts[1].rings[1][0].image, 3);
  EXPECT_EQ(LikelyLayouts({"x.jpg", "b.jpg", "c.jpg", "d.jpg"}).at(0).rings[0][3].index, 3);
}

TEST(LayoutOfSizes, SizesThatDoNotAddUpThrow) {
  EXPECT_THROW(LayoutOfSizes(30, {18, 18}), InputError);
}

}  // namespace keypose::reconstruct::ring_model_test
