#include "composite/composing/join.h"

#include <gtest/gtest.h>

#include <cmath>

namespace keypose::composite::join_test {

/// A bright disk on a dark ground, with a soft edge.
Image8 Disk(double x0, int bright) {
  Image8 picture(120, 90, 3);
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x) {
      const double inside = std::clamp(25.5 - std::hypot(x + 0.5 - x0, y + 0.5 - 45), 0.0, 1.0);
      for (int c = 0; c < 3; ++c)
        picture.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(50 + inside * (bright - 50)));
    }
  return picture;
}

ImageF CoverageOfDisk() {
  ImageF coverage(120, 90, 1);
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x)
      *coverage.at(x, y) =
          static_cast<float>(std::clamp(25.5 - std::hypot(x + 0.5 - 60, y + 0.5 - 45), 0.0, 1.0));
  return coverage;
}

TEST(Join, EqualPicturesJoinPerfectly) {
  const JoinFigures figures = MeasureJoin(Disk(60, 200), Disk(60, 200), CoverageOfDisk());
  EXPECT_EQ(figures.psnr_db, 99);
  EXPECT_EQ(figures.edge_px, 0);
  EXPECT_EQ(figures.colour_levels, 0);
  EXPECT_EQ(figures.edge_share, 1);
  EXPECT_EQ(figures.box[0], 60 - 25 - 8);
  EXPECT_EQ(figures.box[3], 45 + 25 + 8);
}

TEST(Join, ADisksShiftIsFoundAlongItsNormals) {
  const JoinFigures figures = MeasureJoin(Disk(60, 200), Disk(61.2, 200), CoverageOfDisk());
  EXPECT_NEAR(figures.edge_px, 1.2 * 2 / M_PI, 0.08) << "the mean of |cosine| round the disk";
  EXPECT_LT(figures.psnr_db, 35);
}

TEST(Join, AColourIsADifferenceOfColour) {
  const JoinFigures figures = MeasureJoin(Disk(60, 206), Disk(60, 200), CoverageOfDisk());
  EXPECT_NEAR(figures.colour_levels, 6, 0.3);
  EXPECT_LT(figures.edge_px, 0.1);
}

TEST(Join, NothingCoveredIsNoJoin) {
  const JoinFigures figures = MeasureJoin(Disk(60, 200), Disk(60, 200), ImageF(120, 90, 1));
  EXPECT_EQ(figures.psnr_db, 0);
  EXPECT_EQ(figures.box[2], 0);
}

TEST(Join, SideBySideShowsFourTimesTheDifference) {
  const Image8 sheet = SideBySide(Image8(10, 5, 3, 100), Image8(10, 5, 3, 103));
  EXPECT_EQ(sheet.width, 3 * 10 + 2 * 4);
  EXPECT_EQ(sheet.at(0, 0)[0], 100);
  EXPECT_EQ(sheet.at(14, 0)[0], 103);
  EXPECT_EQ(sheet.at(28, 0)[0], 128 + 12);
}

}  // namespace keypose::composite::join_test
