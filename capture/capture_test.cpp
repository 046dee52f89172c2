#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "capture/pictures/contact_sheet.h"
#include "capture/pictures/overlap.h"
#include "capture/pictures/photograph_checks.h"
#include "capture/pictures/photograph_quality.h"
#include "capture/pictures/working_image.h"
#include "capture/segmentation/masking.h"
#include "capture/testing/test_images.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/exif_focal.h"

namespace keypose::capture::capture_test {

using ::testing::HasSubstr;

template <class Call>
std::string MessageOf(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

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

Photograph Photo(const std::string& name, int width, int height, std::uint64_t digest,
                 double focal_px = 0) {
  Photograph photograph;
  photograph.name = name;
  photograph.width = width;
  photograph.height = height;
  photograph.digest = digest;
  photograph.bytes = 10;
  photograph.focal_px = focal_px;
  return photograph;
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

TEST(FocalPx, ReadsWhatExifOffers) {
  EXPECT_DOUBLE_EQ(FocalPx(3000, 2000, 50, 0, 0), 50.0 / 36 * 3000);
  EXPECT_DOUBLE_EQ(FocalPx(2000, 3000, 50, 0, 0),
                   50.0 / 36 * 3000);  // portrait: still the longer side
  EXPECT_DOUBLE_EQ(FocalPx(4272, 2848, 0, 50, 22.2), 50 / 22.2 * 4272);
  EXPECT_DOUBLE_EQ(FocalPx(4000, 3000, 0, 4.5, 6.2),
                   4.5 / 6.2 * 4000);  // a phone: small sensor, small pixels
  // Reduced: a sensor 8 mm wide with pixels of 5 um does not exist.
  EXPECT_DOUBLE_EQ(FocalPx(1536, 1024, 0, 50, 8.0), 50.0 / 23 * 1536);
  EXPECT_DOUBLE_EQ(FocalPx(1536, 1024, 0, 50, 0), 50.0 / 23 * 1536);
  EXPECT_EQ(FocalPx(4000, 3000, 0, 4.5, 0), 0);
  EXPECT_EQ(FocalPx(4000, 3000, 0, 0, 22), 0);
}

TEST(QuarterTurns, TurnsPortraitsOfTheSameCamera) {
  const auto turns = QuarterTurns(
      {Photo("a.jpg", 30, 20, 1), Photo("b.jpg", 20, 30, 2), Photo("c.jpg", 30, 20, 3)});
  EXPECT_EQ(turns, (std::vector<char>{0, 1, 0}));
}

TEST(QuarterTurns, OfEachCameraTheRarerWayIsTurned) {
  const auto turns =
      QuarterTurns({Photo("a", 30, 20, 1), Photo("b", 60, 80, 2), Photo("c", 80, 60, 3),
                    Photo("d", 60, 80, 4), Photo("e", 20, 30, 5), Photo("f", 30, 20, 6)});
  EXPECT_EQ(turns, (std::vector<char>{0, 0, 1, 0, 1, 0}));
}

TEST(GroupedBySize, PutsTheMostCommonFirstAndTheOthersAreNamed) {
  const std::vector<Photograph> photographs = {Photo("odd.jpg", 31, 20, 1),
                                               Photo("a.jpg", 30, 20, 2), Photo("b.jpg", 20, 30, 3),
                                               Photo("c.jpg", 30, 20, 4)};
  const std::vector<SizeGroup> groups = GroupedBySize(photographs, QuarterTurns(photographs));
  ASSERT_EQ(groups.size(), 2U);
  EXPECT_EQ(groups[0].photographs, (std::vector<std::size_t>{1, 2, 3}));
  EXPECT_EQ(groups[0].width, 30);
  EXPECT_EQ(DifferentSizes(photographs, groups),
            "the photographs have different sizes: 3 are 30 x 20, 1 is 31 x 20: odd.jpg");
}

TEST(RequireEnoughAndDistinct, NamesCopies) {
  EXPECT_THAT(MessageOf([] {
                RequireEnoughAndDistinct(
                    {Photo("a.jpg", 3, 2, 7), Photo("b.jpg", 3, 2, 8), Photo("copy.jpg", 3, 2, 7)},
                    2, "photos");
              }),
              HasSubstr("copy.jpg = a.jpg"));
}

TEST(RequireEnoughAndDistinct, TooFewThrow) {
  EXPECT_THAT(MessageOf([] { RequireEnoughAndDistinct({Photo("a.jpg", 3, 2, 7)}, 8, "photos"); }),
              AllOf(HasSubstr("has 1 photograph; at least 8 are needed, and 24 or more all round"),
                    HasSubstr("a further pose takes 6 with `method: fit`")));
  EXPECT_THAT(MessageOf([] { RequireEnoughAndDistinct({Photo("a.jpg", 3, 2, 7)}, 2, "photos"); }),
              HasSubstr("at least 2 are needed, and 6 or more from different sides"));
}

double SpreadOf(const std::vector<Photograph>& photographs) {
  return FocalSpread(photographs, GroupedBySize(photographs, QuarterTurns(photographs)));
}

TEST(FocalSpread, IsRelativeToTheMedianOfASize) {
  EXPECT_DOUBLE_EQ(SpreadOf({Photo("a", 3, 2, 1, 1000), Photo("b", 3, 2, 2, 1000),
                             Photo("c", 3, 2, 3, 1100), Photo("d", 3, 2, 4)}),
                   0.1);
  EXPECT_EQ(SpreadOf({Photo("a", 3, 2, 1)}), 0);
  // Another camera has another focal length.
  EXPECT_DOUBLE_EQ(SpreadOf({Photo("a", 3, 2, 1, 1000), Photo("b", 3, 2, 2, 1010),
                             Photo("c", 3, 2, 3, 1000), Photo("d", 6, 4, 4, 3000)}),
                   0.01);
}

TEST(ContactCell, ShowsTheObjectUntintedAndTheRestTinted) {
  const TestPhoto photo = MakeTestPhoto(0, 240, 160, TestWall::kDark);
  const Image8 cell = ContactCell(photo.image, photo.truth, "a.jpg", 240);
  ASSERT_EQ(cell.width, 240);
  const std::uint8_t *corner = cell.at(5, 5), *middle = cell.at(118, 84);
  EXPECT_GT(corner[0], corner[1] + 60);  // magenta
  for (int c = 0; c < 3; ++c) EXPECT_EQ(middle[c], photo.image.at(118, 84)[c]);
}

/// Patches of random grey, 9 pixels wide; `shift` moves them, `pattern` selects them.
Preview Patches(int pattern, int shift) {
  Preview preview{Image8(320, 240, 1), Image8(320, 240, 1, 255)};
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      const auto column = static_cast<std::uint32_t>((x + shift) / 9),
                 row = static_cast<std::uint32_t>(y / 9);
      const std::uint32_t cell =
          column * 73856093U ^ row * 19349663U ^ static_cast<std::uint32_t>(pattern) * 83492791U;
      const std::uint32_t mixed = (cell ^ (cell >> 13)) * 0x5bd1e995U;
      *preview.grey.at(x, y) = static_cast<std::uint8_t>(60 + (mixed >> 15) % 140);
    }
  return preview;
}

TEST(SharedPlaces, JoinsPhotographsOfOneSideAndNotThoseOfTwo) {
  const std::vector<ImageTie> ties =
      SharedPlaces({Patches(1, 0), Patches(2, 0), Patches(1, 5), Patches(2, 5)});
  ASSERT_EQ(ties.size(), 2U);
  EXPECT_EQ(ties[0].first, 0);
  EXPECT_EQ(ties[0].second, 2);
  EXPECT_EQ(ties[1].first, 1);
  EXPECT_EQ(ties[1].second, 3);
}

}  // namespace keypose::capture::capture_test
