#include "core/io/pictures/drawn_matte.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/io/pictures/png_io.h"
#include "core/pictures/given_matte.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::drawn_matte_test {

using ::testing::HasSubstr;

/// 40 x 30: a soft-edged disc, 255 inside.
Image8 SoftDisc() {
  Image8 disc(40, 30, 1);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x)
      *disc.at(x, y) = static_cast<std::uint8_t>(
          std::lround(255 * std::clamp((10 - std::hypot(x - 20, y - 15)) / 4, 0.0, 1.0)));
  return disc;
}

Image8 HardDisc(int low, int high) {
  Image8 disc = SoftDisc();
  for (auto& value : disc.data) value = static_cast<std::uint8_t>(value > 127 ? high : low);
  return disc;
}

class DrawnMatteFile : public ::testing::Test, public TestingFolder {
 public:
  DrawnMatte Read(const Image8& image) {
    WritePng(path() / "m.png", image);
    return ReadDrawnMatte(path() / "m.png");
  }
};

TEST_F(DrawnMatteFile, SoftBordersStay) {
  const DrawnMatte drawn = Read(SoftDisc());
  EXPECT_EQ(drawn.matte.data, SoftDisc().data);
  EXPECT_FALSE(drawn.stretched);
}

TEST_F(DrawnMatteFile, TwoLevelsAreBlackAndWhiteHoweverSmall) {
  for (const auto& [low, high] : {std::pair{0, 1}, {0, 100}, {3, 4}, {0, 255}}) {
    const DrawnMatte drawn = Read(HardDisc(low, high));
    EXPECT_EQ(drawn.matte.data, HardDisc(0, 255).data) << high;
    EXPECT_EQ(drawn.stretched, high != 255) << high;
  }
  ImageF sixteen(40, 30, 1);
  const Image8 disc = HardDisc(0, 1);
  for (std::size_t i = 0; i < disc.data.size(); ++i) sixteen.data[i] = disc.data[i] / 257.0F;
  WriteLevels(path() / "m.png", sixteen, 16);
  EXPECT_EQ(ReadDrawnMatte(path() / "m.png").matte.data, HardDisc(0, 255).data);
}

TEST_F(DrawnMatteFile, AFewPixelsOfAnotherLevelAreNoise) {
  for (const auto& [level, noise] : {std::pair{0, 1}, {254, 255}, {255, 254}}) {
    Image8 matte(120, 90, 1, static_cast<std::uint8_t>(level));
    for (const int at : {400, 5000, 9000}) matte.data[at] = static_cast<std::uint8_t>(noise);
    const DrawnMatte drawn = Read(matte);
    EXPECT_EQ(drawn.matte.data, matte.data) << level;
    EXPECT_FALSE(drawn.stretched);
    EXPECT_EQ(IsEmptyMatte(drawn.matte), level == 0);
    EXPECT_EQ(IsFullMatte(drawn.matte), level != 0);
  }
  Image8 small(120, 90, 1);
  std::fill_n(small.data.begin() + 5000, 6, std::uint8_t{1});
  EXPECT_EQ(Read(small).matte.data[5005], 255) << "6 of 10800 pixels";
}

TEST_F(DrawnMatteFile, ANearlyBlackJpegIsEmpty) {
  for (const int most : {1, 2, 6}) {
    Image8 black(40, 30, 1);
    for (std::size_t p = 0; p < black.data.size(); ++p)
      black.data[p] = static_cast<std::uint8_t>(p * 7 / 3 % (most + 1));
    WriteImage(path() / "m.jpg", black, 100);
    const DrawnMatte drawn = ReadDrawnMatte(path() / "m.jpg");
    EXPECT_TRUE(IsEmptyMatte(drawn.matte)) << most;
    EXPECT_FALSE(drawn.stretched) << most;
  }
  WriteImage(path() / "m.jpg", HardDisc(0, 255), 100);
  EXPECT_FALSE(IsEmptyMatte(ReadDrawnMatte(path() / "m.jpg").matte));
}

TEST_F(DrawnMatteFile, OneLevelIsKept) {
  for (const int level : {0, 90, 255}) {
    const DrawnMatte drawn = Read(Image8(40, 30, 1, static_cast<std::uint8_t>(level)));
    EXPECT_EQ(drawn.matte.data, Image8(40, 30, 1, static_cast<std::uint8_t>(level)).data);
    EXPECT_EQ(IsEmptyMatte(drawn.matte), level == 0);
    EXPECT_FALSE(CoversBorder(drawn.matte)) << "all, not the border alone";
  }
}

TEST_F(DrawnMatteFile, AlphaThatDiffersIsTheMatte) {
  Image8 cutout(40, 30, 4, 200);
  const Image8 disc = SoftDisc();
  for (std::size_t p = 0; p < disc.data.size(); ++p) {
    cutout.data[4 * p] = static_cast<std::uint8_t>(p * 7 % 256);
    cutout.data[4 * p + 3] = disc.data[p];
  }
  EXPECT_EQ(Read(cutout).matte.data, disc.data);
}

TEST_F(DrawnMatteFile, AlphaThatHidesAllIsAnEmptyMatte) {
  Image8 cutout(40, 30, 4, 180);
  for (std::size_t p = 0; p < 40 * 30; ++p) {
    cutout.data[4 * p] = static_cast<std::uint8_t>(p * 7 % 256);
    cutout.data[4 * p + 3] = 0;
  }
  EXPECT_EQ(Read(cutout).matte.data, Image8(40, 30, 1).data);
}

TEST_F(DrawnMatteFile, PicturesInColoursAndDarkOnesAreRefusedByName) {
  Image8 photograph(40, 30, 3);
  for (std::size_t i = 0; i < photograph.data.size(); ++i)
    photograph.data[i] = static_cast<std::uint8_t>(i * 41 % 256);
  EXPECT_THROW(Read(photograph), InputError);
  Image8 labels = HardDisc(0, 2);
  labels.data[0] = 1;
  try {
    Read(labels);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("matte m.png is dark all over"));
  }
}

TEST(PlacedMatte, OfANearlySquarePictureIsTurnedToo) {
  MatteChange change;
  Image8 stored(40, 39, 1);
  *stored.at(5, 0) = 255;
  const Image8 upright = PlacedMatte(stored, 39, 40, 6, "matte", &change);
  EXPECT_TRUE(change.turned);
  EXPECT_FALSE(change.resized);
  ASSERT_EQ(upright.width, 39);
  EXPECT_EQ(*upright.at(38, 5), 255);
  EXPECT_EQ(PlacedMatte(stored, 40, 39, 6, "matte", &change).data, stored.data);
  EXPECT_FALSE(change.turned);
}

TEST(PlacedMatte, HalfSizeAndAsStoredAreBroughtOverThePicture) {
  MatteChange change;
  const Image8 twice = PlacedMatte(SoftDisc(), 80, 60, 1, "matte", &change);
  ASSERT_EQ(twice.width, 80);
  EXPECT_TRUE(change.resized);
  EXPECT_FALSE(change.turned);
  EXPECT_EQ(*twice.at(40, 30), 255);
  EXPECT_EQ(*twice.at(2, 2), 0);
  Image8 stored(40, 30, 1);
  *stored.at(5, 0) = 255;
  const Image8 upright = PlacedMatte(stored, 30, 40, 6, "matte", &change);  // a quarter clockwise
  EXPECT_TRUE(change.turned);
  EXPECT_EQ(*upright.at(29, 5), 255);
  EXPECT_THROW(PlacedMatte(stored, 30, 40, 1, "matte", nullptr), InputError);
  EXPECT_THROW(PlacedMatte(stored, 400, 300, 1, "matte", nullptr), InputError);
}

}  // namespace keypose::drawn_matte_test
