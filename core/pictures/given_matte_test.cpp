#include "core/pictures/given_matte.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace keypose::given_matte_test {

/// White with a black block in the middle.
Image8 Surroundings(int width, int height) {
  Image8 matte(width, height, 1, 255);
  for (int y = height / 4; y < height / 2; ++y)
    std::fill_n(matte.at(width / 4, y), width / 2, std::uint8_t{0});
  return matte;
}

TEST(HasShapeOf, ToTheRoundingOfEither) {
  EXPECT_TRUE(HasShapeOf(Image8(40, 24, 1), 80, 48));
  EXPECT_TRUE(HasShapeOf(Image8(40, 24, 1), 81, 49));
  EXPECT_TRUE(HasShapeOf(Image8(400, 300, 1), 101, 76)) << "75.75 lines, rounded";
  EXPECT_FALSE(HasShapeOf(Image8(40, 24, 1), 80, 52));
  EXPECT_FALSE(HasShapeOf(Image8(40, 24, 1), 24, 40));
}

TEST(CanLieOn, WhatIsAnEighthOfItsSize) {
  EXPECT_TRUE(CanLieOn(Image8(40, 30, 1), 320, 240));
  EXPECT_FALSE(CanLieOn(Image8(40, 30, 1), 360, 270));
  EXPECT_TRUE(CanLieOn(Image8(400, 300, 1), 40, 30));
  EXPECT_FALSE(CanLieOn(Image8(40, 30, 1), 30, 40));
}

TEST(LiesAsStored, WhereThePictureIsOnItsSideAndOnlyThatFits) {
  const Image8 stored(80, 48, 1), nearly_square(40, 39, 1);
  EXPECT_TRUE(LiesAsStored(stored, 48, 80, 6));
  EXPECT_TRUE(LiesAsStored(stored, 24, 40, 8));
  EXPECT_FALSE(LiesAsStored(stored, 48, 80, 3));
  EXPECT_FALSE(LiesAsStored(stored, 80, 48, 6));
  EXPECT_TRUE(LiesAsStored(nearly_square, 39, 40, 6));
  EXPECT_FALSE(LiesAsStored(nearly_square, 40, 39, 6));
  EXPECT_FALSE(LiesAsStored(Image8(40, 40, 1), 40, 40, 6));
}

TEST(IsEmptyMatte, AlsoWithNoise) {
  EXPECT_TRUE(IsEmptyMatte(Image8(4, 3, 1, 8)));
  Image8 matte(4, 3, 1);
  matte.data[5] = 9;
  EXPECT_FALSE(IsEmptyMatte(matte));
  EXPECT_TRUE(IsEmptyMatte(ImageF(4, 3, 1, 8)));
  EXPECT_FALSE(IsEmptyMatte(ImageF(4, 3, 1, 8.5F)));
}

TEST(IsFullMatte, ButForSpecks) {
  Image8 matte(120, 90, 1, 255);
  EXPECT_TRUE(IsFullMatte(matte));
  std::fill_n(matte.at(40, 40), 10, std::uint8_t{0});
  EXPECT_TRUE(IsFullMatte(matte)) << "10 of 10800 pixels";
  EXPECT_FALSE(CoversBorder(matte));
  *matte.at(50, 50) = 0;
  EXPECT_FALSE(IsFullMatte(matte));
  EXPECT_TRUE(CoversBorder(matte));
  EXPECT_FALSE(IsFullMatte(Image8(120, 90, 1)));
}

TEST(CoversBorder, WhatSurroundsAFigureDoes) {
  Image8 matte = Surroundings(40, 30);
  EXPECT_TRUE(CoversBorder(matte));
  EXPECT_FALSE(CoversBorder(InvertedMatte(matte)));
  EXPECT_FALSE(CoversBorder(Image8(40, 30, 1, 255))) << "all, not the border alone";
  std::fill_n(matte.at(10, 29), 13, std::uint8_t{0});  // of the 136 pixels of its border
  EXPECT_TRUE(CoversBorder(matte));
  *matte.at(23, 29) = 0;
  EXPECT_FALSE(CoversBorder(matte));
}

TEST(InvertedMatte, KeepsSoftBorders) {
  EXPECT_EQ(InvertedMatte(Image8(4, 3, 1, 90)).data, Image8(4, 3, 1, 165).data);
}

}  // namespace keypose::given_matte_test
