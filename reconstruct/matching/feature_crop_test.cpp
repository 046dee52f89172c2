#include "reconstruct/matching/feature_crop.h"

#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::reconstruct::feature_crop_test {

/// Stripes, with a mask of 40 x 30 pixels.
Image8 Stripes() {
  Image8 photo(400, 300, 1);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 400; ++x) *photo.at(x, y) = x % 4 < 2 ? 40 : 200;
  return photo;
}

Image8 Mask() {
  Image8 mask(400, 300, 1);
  for (int y = 150; y < 180; ++y)
    for (int x = 200; x < 240; ++x) *mask.at(x, y) = 255;
  return mask;
}

TEST(CropToObject, TheObjectIsUnchangedAndTheFarBackgroundIsPlain) {
  constexpr int kMargin = 5;
  const Image8 photo = Stripes();
  const ObjectCrop crop = CropToObject(photo, Mask(), kMargin);
  ASSERT_LT(crop.image.width, 200);
  for (int y = 0; y < crop.image.height; ++y)
    for (int x = 0; x < crop.image.width; ++x) {
      const int px = crop.x0 + x, py = crop.y0 + y;
      const bool near =
          px >= 200 - kMargin && px < 240 + kMargin && py >= 150 - kMargin && py < 180 + kMargin;
      ASSERT_EQ(*crop.mask.at(x, y), near ? 255 : 0) << px << " " << py;
      if (near) {
        ASSERT_EQ(*crop.image.at(x, y), *photo.at(px, py));
      }
    }
  EXPECT_NEAR(*crop.image.at(0, 0), 120, 10);
  EXPECT_NEAR(*crop.image.at(2, 0), 120, 10);
}

TEST(CropToObject, AnEmptyMaskLeavesThePhotographWhole) {
  const ObjectCrop crop = CropToObject(Stripes(), Image8(400, 300, 1), 5);
  EXPECT_EQ(crop.image.width, 400);
  EXPECT_EQ(crop.image.data, Stripes().data);
  for (const std::uint8_t value : crop.mask.data) ASSERT_EQ(value, 0);
}

TEST(CropToObject, OtherSizesAndColoursThrow) {
  EXPECT_THROW(CropToObject(Stripes(), Image8(399, 300, 1), 5), InputError);
  EXPECT_THROW(CropToObject(Image8(400, 300, 3), Mask(), 5), InputError);
}

}  // namespace keypose::reconstruct::feature_crop_test
