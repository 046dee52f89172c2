#include <gtest/gtest.h>

#include "core/pictures/joined_images.h"

namespace keypose::reconstruct::joined_images_test {

TEST(FallsApart, SixSidesShotManyTimesDoAndRingsOrBareClayDoNot) {
  std::vector<ImageTie> sides, rings, chain;
  for (int i = 0; i + 6 < 34; ++i)
    sides.push_back({i, i + 6, 300});  // six sides, 60 degrees apart, each from several heights
  EXPECT_EQ(JoinedImages(34, sides).size(), 6U);
  EXPECT_TRUE(FallsApart(34, sides, 60));
  for (int ring = 0; ring < 4; ++ring)  // four rings of twelve without common features yet
    for (int k = 0; k < 12; ++k)
      rings.push_back(
          {12 * ring + std::min(k, (k + 1) % 12), 12 * ring + std::max(k, (k + 1) % 12), 300});
  EXPECT_FALSE(FallsApart(48, rings, 60));
  for (int i = 0; i + 1 < 24; ++i)
    if (i % 3 != 2)
      chain.push_back({i, i + 1, 25});  // weak texture: few matches between some neighbours
  EXPECT_EQ(JoinedImages(24, chain).size(), 8U);
  EXPECT_FALSE(FallsApart(24, chain, 60));
  EXPECT_FALSE(FallsApart(24, {}, 60));  // no texture: left to the outlines
}

}  // namespace keypose::reconstruct::joined_images_test
