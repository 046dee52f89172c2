// Borders of masks that were made at a fraction of a picture's size.
#include "capture/segmentation/guided_border.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/pictures/working_image.h"

namespace keypose::capture::guided_border_test {

constexpr int kWidth = 1600, kHeight = 1200, kFraction = 8;

/// Pixels from the border of a figure with two lobes, positive inside.
double Inside(double x, double y) {
  const double angle = std::atan2(y - 590, x - 780);
  return 300 + 90 * std::cos(2 * angle) - std::hypot(x - 780, y - 590);
}

Image8 Photo() {
  Image8 image(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const bool inside = Inside(x + 0.5, y + 0.5) > 0;
      const int grain = (x * 7 + y * 13) % 11 - 5;
      const int light = inside ? 60 + x / 40 : 150 + y / 30;
      for (int c = 0; c < 3; ++c)
        image.at(x, y)[c] = static_cast<std::uint8_t>(light + (inside ? 12 * c : -8 * c) + grain);
    }
  return image;
}

/// The figure's mask at an eighth of the size, cut into pixels.
Image8 SmallMask(double grown) {
  Image8 mask(kWidth / kFraction, kHeight / kFraction, 1, 0);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (Inside((x + 0.5) * kFraction, (y + 0.5) * kFraction) + grown > 0) *mask.at(x, y) = 255;
  return mask;
}

/// The largest distance from the true border of a pixel on the wrong side, and their number over
/// the border's length.
struct Miss {
  double largest = 0, mean = 0;
};
Miss MissOf(const Image8& mask) {
  constexpr double kLength = 2 * M_PI * 330;
  Miss miss;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const double inside = Inside(x + 0.5, y + 0.5);
      if ((inside > 0) == (*mask.at(x, y) == 255)) continue;
      miss.largest = std::max(miss.largest, std::abs(inside));
      miss.mean += 1 / kLength;
    }
  return miss;
}

TEST(GuidedMask, FindsTheBorderThatTheSmallMaskMisses) {
  const Image8 photo = Photo();
  for (const double grown : {-4.0, 0.0, 4.0}) {  // half a pixel of the small mask
    const Image8 small = SmallMask(grown);
    const Miss before = MissOf(EnlargedMask(small, 1, kWidth, kHeight)),
               after = MissOf(GuidedMask(photo, small, 2 * kFraction, 5));
    EXPECT_LE(after.largest, 2) << grown;
    EXPECT_LE(after.mean, 0.5) << grown;  // boundary matting needs a border within a pixel
    EXPECT_GT(before.mean, 2 * after.mean) << grown;
  }
}

TEST(GuidedMask, IsEmptyWhereTheSmallMaskIs) {
  const Image8 mask = GuidedMask(Photo(), Image8(200, 150, 1, 0), 16, 5);
  EXPECT_EQ(mask.data, Image8(kWidth, kHeight, 1, 0).data);
}

TEST(EnlargedMask, PlacesHavePixelsOfTheirOwnEighths) {
  for (const int eighths : {1, 3, 4, 5}) {
    // The last column and row reach beyond the picture.
    const int width = 803, height = 605;
    Image8 mask((width * eighths + 7) / 8, (height * eighths + 7) / 8, 1, 0);
    const auto inside = [](double x, double y) { return std::hypot(x - 401, y - 333) < 250; };
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x)
        if (inside((x + 0.5) * 8 / eighths, (y + 0.5) * 8 / eighths)) *mask.at(x, y) = 255;
    const Image8 large = EnlargedMask(mask, eighths, width, height);
    double x_sum = 0, y_sum = 0, count = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        if (*large.at(x, y) == 255) x_sum += x + 0.5, y_sum += y + 0.5, count += 1;
    EXPECT_NEAR(x_sum / count, 401, 0.5 / eighths) << eighths;
    EXPECT_NEAR(y_sum / count, 333, 0.5 / eighths) << eighths;
    EXPECT_NEAR(std::sqrt(count / M_PI), 250, 0.4) << eighths;
  }
}

}  // namespace keypose::capture::guided_border_test
