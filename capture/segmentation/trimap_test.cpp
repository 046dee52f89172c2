#include "capture/segmentation/trimap.h"

#include <gtest/gtest.h>

namespace keypose::capture::trimap_test {

TEST(TrimapOf, TwoPixelsOnEitherSideOfTheBorderAreUnknown) {
  Image8 mask(40, 40, 1);
  for (int y = 10; y < 30; ++y)
    for (int x = 10; x < 30; ++x) *mask.at(x, y) = 255;
  const Image8 trimap = TrimapOf(mask);
  for (int x = 0; x < 40; ++x) {
    TrimapLabel expected = kUnknown;
    if (x < 8 || x >= 32) expected = kBackground;
    if (x >= 12 && x < 28) expected = kObject;
    EXPECT_EQ(*trimap.at(x, 20), expected) << x;
  }
}

}  // namespace keypose::capture::trimap_test
