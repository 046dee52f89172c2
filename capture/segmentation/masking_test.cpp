#include "capture/segmentation/masking.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "capture/pictures/working_image.h"
#include "capture/testing/input_error.h"
#include "capture/testing/test_images.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"

namespace keypose::capture::masking_test {

using ::testing::HasSubstr;

double Iou(const Image8& a, const Image8& b) {
  double both = 0, either = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i)
    both += a.data[i] > 127 && b.data[i] > 127, either += a.data[i] > 127 || b.data[i] > 127;
  return both / either;
}

struct Set {
  std::vector<Image8> images, truths;
};

Set MakeSet(int count, int width, int height, TestWall wall) {
  Set set;
  for (int i = 0; i < count; ++i) {
    TestPhoto photo = MakeTestPhoto(i, width, height, wall);
    set.images.push_back(std::move(photo.image));
    set.truths.push_back(std::move(photo.truth));
  }
  return set;
}

class SegmentSetOn : public ::testing::TestWithParam<TestWall> {};

// The outline is known to the pixel; at this size one pixel all round is 2 % of the area, so 0.95
// allows a pixel and a little.
TEST_P(SegmentSetOn, FindsTheObjectInEveryPhotograph) {
  const Set set = MakeSet(10, 240, 160, GetParam());
  const auto masks = SegmentSet(set.images, {}, {}, MaskOptions{});
  for (std::size_t i = 0; i < masks.size(); ++i)
    EXPECT_GT(Iou(masks[i], set.truths[i]), 0.95) << "photograph " << i;
}

TEST_P(SegmentSetOn, CleanPlateFindsTheObjectInASinglePhotograph) {
  const Set set = MakeSet(1, 240, 160, GetParam());
  const auto masks = SegmentSet(set.images, MakeTestWall(240, 160, GetParam()), {}, MaskOptions{});
  EXPECT_GT(Iou(masks[0], set.truths[0]), 0.95);
}

INSTANTIATE_TEST_SUITE_P(Walls, SegmentSetOn, ::testing::Values(TestWall::kLight, TestWall::kDark));

TEST(SegmentSet, SameBitsForAnyThreadCount) {
  const Set set = MakeSet(6, 180, 120, TestWall::kLight);
  SetThreadCount(1);
  const auto one = SegmentSet(set.images, {}, {}, MaskOptions{});
  SetThreadCount(4);
  const auto four = SegmentSet(set.images, {}, {}, MaskOptions{});
  SetThreadCount(0);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].data, four[i].data);
}

TEST(SegmentSet, CleanPlateThatEqualsThePhotographGivesABlackMask) {
  const Image8 wall = MakeTestWall(120, 80, TestWall::kDark);
  EXPECT_EQ(MaskFraction(SegmentSet({wall}, wall, {}, MaskOptions{})[0]), 0);
}

TEST(SegmentSet, CleanPlateOfAnotherShapeThrows) {
  const Image8 image = MakeTestWall(120, 80, TestWall::kDark),
               clean_plate = MakeTestWall(100, 100, TestWall::kDark);
  EXPECT_THAT(MessageOf([&] { SegmentSet({image}, clean_plate, {}, MaskOptions{}); }),
              HasSubstr("clean plate has another shape"));
}

TEST(SegmentSet, NoImagesThrow) { EXPECT_THROW(SegmentSet({}, {}, {}, MaskOptions{}), InputError); }

TEST(RefinedMask, FollowsTheEdgeAtFullResolution) {
  const TestPhoto large = MakeTestPhoto(3, 720, 480, TestWall::kDark);
  const Image8 small = WorkingImage(large.image, 240);
  const auto masks =
      SegmentSet({small, WorkingImage(MakeTestPhoto(4, 720, 480, TestWall::kDark).image, 240)}, {},
                 {}, MaskOptions{});
  const Image8 mask = RefinedMask(large.image, masks[0]);
  ASSERT_EQ(mask.width, 720);
  EXPECT_GT(Iou(mask, large.truth), 0.97);
}

/// The image in the middle of one of twice the size.
Image8 Framed(const Image8& image, std::uint8_t value) {
  Image8 framed(2 * image.width, 2 * image.height, image.channels, value);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      std::copy_n(image.at(x, y), image.channels,
                  framed.at(x + image.width / 2, y + image.height / 2));
  return framed;
}

TEST(RefinedMask, WhatLiesFarFromTheFigureDoesNotMatter) {
  const TestPhoto photo = MakeTestPhoto(3, 720, 480, TestWall::kDark);
  const Image8 coarse = WorkingImage(photo.truth, 240);
  const Image8 mask = RefinedMask(photo.image, coarse),
               framed = RefinedMask(Framed(photo.image, 90), Framed(coarse, 0));
  EXPECT_GT(Iou(mask, photo.truth), 0.97);
  EXPECT_EQ(framed.data, Framed(mask, 0).data);
  EXPECT_EQ(MaskFraction(RefinedMask(photo.image, Image8(240, 160, 1, 0))), 0);
}

// A shadow as large as a third of the figure, next to it, in every photograph: colour alone
// classifies it as figure.
TEST(SegmentSet, LeavesOutTheShadowOnTheTable) {
  std::vector<Image8> images, truths;
  for (int i = 0; i < 12; ++i) {
    TestPhoto photo = MakeTestPhoto(i, 240, 160, TestWall::kLight);
    for (int y = 0; y < 160; ++y)
      for (int x = 0; x < 240; ++x) {
        const double dx = (x - 165) / 50.0, dy = (y - 118) / 16.0,
                     deep = 0.55 + 0.45 * std::clamp(4 * (dx * dx + dy * dy - 0.75), 0.0, 1.0);
        if (*photo.truth.at(x, y) == 0)
          for (int c = 0; c < 3; ++c)
            photo.image.at(x, y)[c] = static_cast<std::uint8_t>(photo.image.at(x, y)[c] * deep);
      }
    images.push_back(std::move(photo.image));
    truths.push_back(std::move(photo.truth));
  }
  const auto masks = SegmentSet(images, {}, {}, MaskOptions{});
  for (std::size_t i = 0; i < masks.size(); ++i) {
    double both = 0, either = 0;
    for (std::size_t p = 0; p < truths[i].data.size(); ++p) {
      both += masks[i].data[p] > 127 && truths[i].data[p] > 127;
      either += masks[i].data[p] > 127 || truths[i].data[p] > 127;
    }
    EXPECT_GT(both / either, 0.93) << "photograph " << i;
  }
}

}  // namespace keypose::capture::masking_test
