#include "capture/pictures/photograph_quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/pictures/working_image.h"
#include "capture/testing/test_images.h"

namespace keypose::capture::photograph_quality_test {

TEST(MeasureQuality, CrispnessFallsWithBlurAndHardlyWithContrast) {
  const TestPhoto photo = MakeTestPhoto(0, 360, 240, TestWall::kDark);
  const double sharp = MeasureQuality(Grey(photo.image), photo.truth).crispness;
  const double blurred = MeasureQuality(Grey(Blurred(photo.image, 4)), photo.truth).crispness;
  Image8 faint = photo.image;
  for (std::uint8_t& v : faint.data) v = static_cast<std::uint8_t>(100 + v / 4);
  EXPECT_GT(sharp, 0.5);
  EXPECT_LT(blurred, 0.25);
  EXPECT_NEAR(MeasureQuality(Grey(faint), photo.truth).crispness, sharp, 0.05);
}

TEST(MeasureQuality, ExposureAndClippingAreThoseInsideTheMask) {
  Image8 grey(100, 100, 1, 10), mask(100, 100, 1, 0);
  for (int y = 30; y < 70; ++y)
    for (int x = 30; x < 70; ++x) *grey.at(x, y) = 255, *mask.at(x, y) = 255;
  const PhotographQuality quality = MeasureQuality(grey, mask);
  EXPECT_EQ(quality.exposure, 255);
  EXPECT_EQ(quality.clipped, 1);
}

}  // namespace keypose::capture::photograph_quality_test
