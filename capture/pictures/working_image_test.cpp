#include "capture/pictures/working_image.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace keypose::capture::working_image_test {

TEST(WorkingImage, LongerSideHasTheWorkingSizeAndNothingIsEnlarged) {
  const Image8 image(400, 300, 3, 90);
  const Image8 small = WorkingImage(image, 200);
  EXPECT_EQ(small.width, 200);
  EXPECT_EQ(small.height, 150);
  EXPECT_EQ(*small.at(100, 75), 90);
  EXPECT_EQ(WorkingImage(image, 800).width, 400);
}

TEST(EnlargedMask, KeepsItsSharePixelForPixelAndIsBlackOrWhite) {
  Image8 mask(50, 40, 1);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 25; ++x) *mask.at(x, y) = 255;
  for (const int eighths : {2, 3, 4}) {
    const int width = 50 * 8 / eighths, height = 40 * 8 / eighths;
    const Image8 large = EnlargedMask(mask, eighths, width, height);
    EXPECT_NEAR(MaskFraction(large), 0.5, 1.0 / width) << eighths;
    for (const std::uint8_t value : large.data) ASSERT_TRUE(value == 0 || value == 255);
  }
}

TEST(Grey, IsTheLumaOfBt601) {
  Image8 image(1, 1, 3);
  const int expected[3] = {76, 150, 29};
  for (int c = 0; c < 3; ++c) {
    image.data = {0, 0, 0};
    image.data[c] = 255;
    EXPECT_EQ(Grey(image).data[0], expected[c]);
  }
}

TEST(MaskFraction, OfNoPixelsIsZero) { EXPECT_EQ(MaskFraction(Image8()), 0); }

}  // namespace keypose::capture::working_image_test
