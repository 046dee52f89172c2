#include "core/pictures/joined_images.h"

#include <gtest/gtest.h>

#include "core/pictures/render.h"
#include "core/values/errors.h"

namespace keypose::joined_images_test {

TEST(TileImages, PlacesImagesInRowsWithGaps) {
  const std::vector<Image8> images = {Image8(4, 2, 3, 10), Image8(4, 2, 1, 20),
                                      Image8(2, 2, 3, 30)};
  const Image8 sheet = TileImages(images, 2, 1);
  EXPECT_EQ(sheet.width, 9);
  EXPECT_EQ(sheet.height, 5);
  EXPECT_EQ(sheet.at(0, 0)[0], 10);
  EXPECT_EQ(sheet.at(5, 1)[2], 20);
  EXPECT_EQ(sheet.at(4, 0)[0], 255);
  EXPECT_EQ(sheet.at(1, 3)[1], 30);
  EXPECT_THROW(TileImages({}, 2), InputError);
}

}  // namespace keypose::joined_images_test
