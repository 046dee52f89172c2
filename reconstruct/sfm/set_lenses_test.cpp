#include "reconstruct/sfm/set_lenses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace keypose::reconstruct::set_lenses_test {

using ::testing::ElementsAre;

/// A photograph of a set, reduced from another size if that is given.
CapturedImage Photograph(int width, int height, double focal_px, int of_width = 0,
                         int of_height = 0) {
  CapturedImage image;
  image.width = width, image.height = height;
  image.photograph_width = of_width, image.photograph_height = of_height;
  image.focal_px = focal_px;
  return image;
}

TEST(LensesOf, EachSizeIsALensAlsoIfItWasMadeTheSameSize) {
  ImageSet set;
  for (int i = 0; i < 9; ++i)
    set.images.push_back(i % 3 == 0   ? Photograph(2000, 1500, 2400, 4000, 3000)
                         : i % 3 == 1 ? Photograph(2000, 1500, 0, 1500 * 2, 2000 * 2)
                                      : Photograph(2000, 1500, 0));
  const SetLenses lenses = LensesOf(set);
  ASSERT_EQ(lenses.cameras.size(), 2U);  // a portrait that was turned is of the same camera
  EXPECT_THAT(lenses.of_image, ElementsAre(0, 0, 1, 0, 0, 1, 0, 0, 1));
  EXPECT_EQ(lenses.cameras[0].fx, 2400);
  EXPECT_EQ(lenses.cameras[1].fx, 2400);  // the only focal length that is known
  EXPECT_TRUE(lenses.focal_known);
}

}  // namespace keypose::reconstruct::set_lenses_test
