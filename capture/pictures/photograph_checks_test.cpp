#include "capture/pictures/photograph_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/testing/input_error.h"
#include "core/values/exif_focal.h"

namespace keypose::capture::photograph_checks_test {

using ::testing::HasSubstr;

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

TEST(FocalPx, ReadsWhatExifOffers) {
  // by the diagonal, which of 3:2 is the same as by 36 mm of width, of a portrait too
  EXPECT_NEAR(FocalPx(3000, 2000, 50, 0, 0), 50.0 / 36 * 3000, 1e-3);
  EXPECT_NEAR(FocalPx(2000, 3000, 50, 0, 0), 50.0 / 36 * 3000, 1e-3);
  EXPECT_NEAR(FocalPx(4000, 3000, 26, 0, 0), 26 / 43.2666 * 5000, 1e-2);  // a phone
  EXPECT_NEAR(FocalPx(640, 480, 43, 0, 0), 795.1, 0.1);
  // the sensor is exact where the whole millimetres agree with it, and stale where they do not
  EXPECT_DOUBLE_EQ(FocalPx(4272, 2848, 81, 50, 22.2), 50 / 22.2 * 4272);
  EXPECT_NEAR(FocalPx(2736, 1824, 50, 50, 18), 50.0 / 36 * 2736, 1e-3);
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

}  // namespace keypose::capture::photograph_checks_test
