// Parts of the segmentation: the pixel classifier, the empty set, shadows.
#include "capture/segmentation/empty_set.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/segmentation/trimap.h"
#include "capture/testing/test_images.h"

namespace keypose::capture::empty_set_test {

TEST(FindTakes, SplitsWhereTheSurroundingsChange) {
  std::vector<Image8> images;
  for (int i = 0; i < 5; ++i) images.push_back(MakeTestPhoto(i, 240, 160, TestWall::kLight).image);
  for (int i = 0; i < 3; ++i) images.push_back(MakeTestPhoto(i, 240, 160, TestWall::kDark).image);
  const std::vector<Take> takes = FindTakes(images, 0.06);
  ASSERT_GE(takes.size(), 2U);
  EXPECT_EQ(takes[0].images, (std::vector<std::size_t>{0, 1, 2, 3, 4}));
}

// The empty set is a median over a take, pixel by pixel.
TEST(FindTakes, ATakeHasOneSizeAlsoWhereSizesAlternate) {
  std::vector<Image8> images;
  for (int i = 0; i < 8; ++i)
    images.push_back(
        MakeTestPhoto(i, i % 2 ? 180 : 240, i % 2 ? 120 : 160, TestWall::kLight).image);
  const std::vector<Take> takes = FindTakes(images, 0.06);
  ASSERT_EQ(takes.size(), 2U);
  EXPECT_EQ(TakeOf(takes, 0).images, (std::vector<std::size_t>{0, 2, 4, 6}));
  EXPECT_EQ(TakeOf(takes, 3).images, (std::vector<std::size_t>{1, 3, 5, 7}));
}

TEST(EmptySet, IsWhatTheOthersOfTheTakeShow) {
  std::vector<Image8> lab, trimaps;
  for (int i = 0; i < 5; ++i) {
    Image8 image(80, 60, 3, 0), trimap(80, 60, 1, kBackground);
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 80; ++x) {
        image.at(x, y)[0] = static_cast<std::uint8_t>(x), image.at(x, y)[1] = 120,
                    image.at(x, y)[2] = static_cast<std::uint8_t>(130 + i % 2);
        if (std::abs(x - 15 * i) < 7 && y > 20) *trimap.at(x, y) = kObject, image.at(x, y)[0] = 250;
      }
    lab.push_back(image);
    trimaps.push_back(trimap);
  }
  const Image8 empty = EmptySet(lab, trimaps, {{0, 1, 2, 3, 4}}, 2);
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 80; ++x) ASSERT_EQ(*empty.at(x, y), x) << x << " " << y;
}

TEST(ShadowKinds, IsDarkerOfTheSameHueAndNothingElse) {
  Image8 empty(40, 30, 3), lab;
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x)
      empty.at(x, y)[0] = 200, empty.at(x, y)[1] = 132, empty.at(x, y)[2] = 140;
  const auto kind = [&](int light, int a, int b) {
    lab = empty;
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x)
        lab.at(x, y)[0] = static_cast<std::uint8_t>(light),
                  lab.at(x, y)[1] = static_cast<std::uint8_t>(a),
                  lab.at(x, y)[2] = static_cast<std::uint8_t>(b);
    return *ShadowKinds(lab, empty).at(20, 15);
  };
  EXPECT_GT(kind(140, 131, 136), 0);
  EXPECT_EQ(kind(200, 132, 140), 0);  // not darker
  EXPECT_EQ(kind(230, 132, 140), 0);  // lighter
  EXPECT_EQ(kind(140, 160, 136), 0);  // of another hue
  EXPECT_EQ(kind(30, 128, 130), 0);   // darker than a shadow
}

}  // namespace keypose::capture::empty_set_test
