#include "core/pictures/image_quality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

namespace keypose::image_quality_test {

ImageT<double> Ramp(double gain, double offset) {
  ImageT<double> image(24, 16, 1);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 24; ++x)
      image.at(x, y)[0] = offset + gain * (128 + 60 * std::sin(0.7 * x) * std::cos(0.5 * y));
  return image;
}

TEST(Luma, OfGreyIsTheGrey) {
  const double grey[] = {80, 80, 80}, green[] = {0, 100, 0};
  EXPECT_NEAR(Luma(grey), 80, 1e-12);
  EXPECT_NEAR(Luma(green), 58.7, 1e-12);
}

TEST(Psnr, HasItsEnds) {
  EXPECT_NEAR(Psnr(100.0 * 255 * 255, 100), 0, 1e-12);
  EXPECT_NEAR(Psnr(255.0 * 255, 100), 20, 1e-12);
  EXPECT_EQ(Psnr(0, 100), 99);
  EXPECT_EQ(Psnr(1, 0), 0);
}

TEST(Ssim, IsOneForEqualPicturesAndNegativeForTheNegative) {
  const ImageT<double> image = Ramp(1, 0);
  const std::vector<char> all(image.data.size(), 1);
  EXPECT_NEAR(Ssim(image, image, all), 1, 1e-12);
  EXPECT_LT(Ssim(image, Ramp(-1, 256), all), 0);  // mirrored about the mean grey
}

TEST(Ssim, OfConstantsIsTheFormulasLuminanceTerm) {
  ImageT<double> a(20, 20, 1), b(20, 20, 1);
  a.data.assign(400, 100);
  b.data.assign(400, 120);
  const double c1 = 0.01 * 255 * 0.01 * 255;
  const double wanted = (2 * 100 * 120 + c1) / (100.0 * 100 + 120 * 120 + c1);
  EXPECT_NEAR(Ssim(a, b, std::vector<char>(400, 1)), wanted, 1e-9);
}

TEST(Ssim, PixelsThatAreNotValidDoNotCount) {
  const ImageT<double> image = Ramp(1, 0);
  ImageT<double> other = image;
  std::vector<char> valid(image.data.size(), 1);
  for (std::size_t i = 0; i < 5 * 24; ++i) {
    other.data[i] = 0;
    valid[i] = 0;
  }
  EXPECT_NEAR(Ssim(image, other, valid), 1, 1e-12);
  EXPECT_EQ(Ssim(image, other, std::vector<char>(image.data.size(), 0)), 1);
}

}  // namespace keypose::image_quality_test
