#include "fit/appearance/patch_shift.h"

#include <gtest/gtest.h>

#include <cmath>

namespace keypose::fit::patch_shift_test {

constexpr int kSize = 64;

double Texture(double x, double y) {
  return 120 + 30 * std::sin(0.7 * x + 0.2 * y) + 25 * std::cos(0.3 * x - 0.8 * y) +
         15 * std::sin(0.5 * x * std::cos(0.1 * y));
}

TexturedRender RenderOf(double (*texture)(double, double)) {
  TexturedRender render{ImageT<int>(kSize, kSize, 1, 0), ImageF(kSize, kSize, 1, 5.0f),
                        ImageF(kSize, kSize, 1)};
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) *render.grey.at(x, y) = static_cast<float>(texture(x, y));
  return render;
}

/// The texture moved by (dx, dy), under a light that falls off to one side.
ImageF Photo(double dx, double dy) {
  ImageF photo(kSize, kSize, 1);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      *photo.at(x, y) = static_cast<float>(0.6 * Texture(x - dx, y - dy) + 20 + 1.5 * x - 0.7 * y);
  return photo;
}

PatchShift ShiftIn(const TexturedRender& render, const ImageF& photo) {
  const std::vector<SeenVertex> seen = {{0, {32, 32}, 5, 1}};
  return FindShifts(seen, render, photo, GreyMask(kSize, kSize, 1, 1), 100, 0.5, {})[0];
}

TEST(FindShifts, FindsASubpixelShiftUnderAnotherLight) {
  const PatchShift shift = ShiftIn(RenderOf(Texture), Photo(1.7, -1.2));
  ASSERT_TRUE(shift.found);
  // bilinear samples of a texture with a wavelength of eight pixels
  EXPECT_NEAR(shift.shift.x(), 1.7, 0.05);
  EXPECT_NEAR(shift.shift.y(), -1.2, 0.05);
  EXPECT_GT(shift.correlation, 0.98);
  EXPECT_GT(shift.confidence.trace(), 1.5);
}

TEST(FindShifts, FindsNothingInAnotherTexture) {
  ImageF other(kSize, kSize, 1);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      *other.at(x, y) = static_cast<float>(128 + 40 * std::sin(1.3 * x) * std::sin(1.1 * y + x));
  EXPECT_FALSE(ShiftIn(RenderOf(Texture), other).found);
}

TEST(FindShifts, AStripeIsSureAcrossAndUnsureAlong) {
  const auto stripe = [](double x, double) { return 128 + 50 * std::sin(0.6 * x); };
  ImageF photo(kSize, kSize, 1);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) *photo.at(x, y) = static_cast<float>(stripe(x - 1.0, y));
  const PatchShift shift = ShiftIn(RenderOf(stripe), photo);
  ASSERT_TRUE(shift.found);
  EXPECT_NEAR(shift.shift.x(), 1, 0.05);
  EXPECT_GT(shift.confidence(0, 0), 0.8);
  EXPECT_LT(shift.confidence(1, 1), 0.01);
}

TEST(FindShifts, PixelsOfAnotherDepthHaveNoWeight) {
  TexturedRender render = RenderOf(Texture);
  for (int y = 0; y < kSize; ++y)
    for (int x = 36; x < kSize; ++x) *render.depth.at(x, y) = 9, *render.grey.at(x, y) = 0;
  const PatchShift shift = ShiftIn(render, Photo(0.8, 0.4));
  ASSERT_TRUE(shift.found);
  EXPECT_NEAR(shift.shift.x(), 0.8, 0.05);
  EXPECT_NEAR(shift.shift.y(), 0.4, 0.05);
}

}  // namespace keypose::fit::patch_shift_test
