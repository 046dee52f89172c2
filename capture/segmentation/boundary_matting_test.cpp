// Borders of masks of discs whose coverage of every pixel is known.
#include "capture/segmentation/boundary_matting.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/pictures/srgb.h"

namespace keypose::capture::boundary_matting_test {

constexpr int kSize = 120;
constexpr double kX = 60.2, kY = 59.7;

/// Share of a pixel that a disc covers.
double Cover(int x, int y, double radius) {
  constexpr int kParts = 16;
  int inside = 0;
  for (int j = 0; j < kParts; ++j)
    for (int i = 0; i < kParts; ++i)
      inside += std::hypot(x + (i + 0.5) / kParts - kX, y + (j + 0.5) / kParts - kY) < radius;
  return static_cast<double>(inside) / (kParts * kParts);
}

std::uint8_t Encoded(double linear) {
  return static_cast<std::uint8_t>(std::lround(255 * SrgbFromLinear(linear)));
}

/// A disc of one light in front of a background of another, in linear light, as a lens without blur
/// would show it.
Image8 DiscPhoto(double object, double background, double radius) {
  Image8 image(kSize, kSize, 3);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const double cover = Cover(x, y, radius);
      for (int c = 0; c < 3; ++c)
        image.at(x, y)[c] = Encoded(cover * object + (1 - cover) * background);
    }
  return image;
}

Image8 DiscMask(double radius) {
  Image8 mask(kSize, kSize, 1);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) *mask.at(x, y) = Cover(x, y, radius) > 0.5 ? 255 : 0;
  return mask;
}

int Unlike(const Image8& a, const Image8& b) {
  int count = 0;
  for (std::size_t p = 0; p < a.data.size(); ++p) count += a.data[p] != b.data[p];
  return count;
}

// A border up to half a pixel outside of the true one or nearly a whole one inside, with objects
// darker and brighter than the background.
TEST(MatteBoundary, FindsHalfCover) {
  constexpr double kRadius = 40.3;
  const Image8 truth = DiscMask(kRadius);
  for (const auto& [object, background] : {std::array{0.05, 0.6}, std::array{0.6, 0.05}})
    for (const double off : {-0.9, -0.4, 0.0, 0.3, 0.5}) {
      Image8 mask = DiscMask(kRadius + off);
      MatteBoundary(DiscPhoto(object, background, kRadius), mask);
      EXPECT_LE(Unlike(mask, truth), 4) << object << " before " << background << ", border off by "
                                        << off;  // of 250 border pixels
    }
}

TEST(MatteBoundary, LeavesWhatItCannotTell) {
  const Image8 flat = DiscPhoto(0.300, 0.305, 40.3), mask = DiscMask(41);
  Image8 matted = mask;
  MatteBoundary(flat, matted);
  EXPECT_EQ(matted.data, mask.data);
  Image8 black(kSize, kSize, 1, 0);
  MatteBoundary(flat, black);
  EXPECT_EQ(Unlike(black, Image8(kSize, kSize, 1, 0)), 0);
  Image8 white(kSize, kSize, 1, 255);
  MatteBoundary(flat, white);
  EXPECT_EQ(Unlike(white, Image8(kSize, kSize, 1, 255)), 0);
}

}  // namespace keypose::capture::boundary_matting_test
