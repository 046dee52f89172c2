#include "core/io/pictures/drawn_mask.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/io/pictures/png_io.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::drawn_mask_test {

using ::testing::HasSubstr;

/// 40 x 30: a disc of the upper level on the lower one.
ImageF Disc(float lower, float upper) {
  ImageF levels(40, 30, 1);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) *levels.at(x, y) = std::hypot(x - 20, y - 15) < 9 ? upper : lower;
  return levels;
}

void ExpectDisc(const Image8& mask) {
  ASSERT_EQ(mask.width, 40);
  ASSERT_EQ(mask.channels, 1);
  const ImageF disc = Disc(0, 255);
  for (std::size_t i = 0; i < mask.data.size(); ++i) ASSERT_EQ(mask.data[i], disc.data[i]) << i;
}

std::string Refusal(const ImageF& levels, bool lossless = true) {
  try {
    MaskOfLevels(levels, lossless, "m.png");
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(MaskOfLevels, OfTwoLevelsTheHigherIsTheFigure) {
  for (const auto& [lower, upper] : {std::pair{0.F, 255.F},
                                     {0.F, 1.F},
                                     {1.F, 2.F},
                                     {0.F, 1 / 257.F},
                                     {128.F, 255.F},
                                     {0.F, 127.F}})
    ExpectDisc(MaskOfLevels(Disc(lower, upper), true, "m.png"));
}

TEST(MaskOfLevels, OneLevelIsNothingOrEverything) {
  EXPECT_THAT(MaskOfLevels(Disc(0, 0), true, "").data, ::testing::Each(0));
  EXPECT_THAT(MaskOfLevels(Disc(1, 1), true, "").data, ::testing::Each(255));
  EXPECT_THAT(MaskOfLevels(Disc(255, 255), true, "").data, ::testing::Each(255));
}

TEST(MaskOfLevels, SoftBordersAreCutAtHalf) {
  ImageF levels = Disc(0, 255);
  for (int x = 0; x < 40; ++x) *levels.at(x, 0) = static_cast<float>(x);  // many levels, all dark
  ExpectDisc(MaskOfLevels(levels, true, "m.png"));
}

TEST(MaskOfLevels, LabelsTrimapsAndDarkMasksAreNamed) {
  ImageF labels = Disc(0, 1);
  for (int x = 0; x < 40; ++x) *labels.at(x, 0) = 2;
  EXPECT_THAT(Refusal(labels), HasSubstr("mask m.png has the levels 0, 1, 2"));
  ImageF trimap = Disc(0, 255);
  for (int x = 0; x < 40; ++x) *trimap.at(x, 0) = 128;
  EXPECT_THAT(Refusal(trimap), HasSubstr("0, 128, 255"));
  EXPECT_THAT(Refusal(trimap, false), HasSubstr("0, 128, 255"));
  ImageF ignored = Disc(0, 1);
  for (int x = 0; x < 40; ++x) *ignored.at(x, 0) = 255;
  EXPECT_THAT(Refusal(ignored), HasSubstr("0, 1, 255"));
  ImageF dark = Disc(0, 90);
  for (int x = 0; x < 40; ++x) *dark.at(x, 0) = static_cast<float>(x);
  EXPECT_THAT(Refusal(dark), HasSubstr("brightest level is 90"));
}

TEST(MaskOfLevels, ASecondWhiteIsNoLabel) {
  ImageF mask = Disc(0, 255);
  const ImageF one_white = mask;
  for (float& level : mask.data)
    if (level > 0 && (&level - mask.data.data()) % 2 == 0) level = 250;
  EXPECT_EQ(MaskOfLevels(mask, true, "m.png").data, MaskOfLevels(one_white, true, "m.png").data);
}

TEST(MaskOfLevels, NoiseOfAJpegIsNoLabel) {
  ImageF levels = Disc(0, 255);
  for (int x = 0; x < 40; ++x) *levels.at(x, 0) = x % 2 ? 3 : 0;
  EXPECT_EQ(Refusal(levels, false), "");
  EXPECT_THAT(Refusal(levels, true), HasSubstr("0, 3, 255"));
}

TEST(MaskOfLevels, LossyNoiseAloneIsBlack) {
  for (const float upper : {0.F, 1.F, 8.F}) {
    EXPECT_THAT(MaskOfLevels(Disc(0, upper), false, "").data, ::testing::Each(0)) << upper;
    EXPECT_THAT(MaskOfLevels(Disc(upper, upper), false, "").data, ::testing::Each(0)) << upper;
  }
  ExpectDisc(MaskOfLevels(Disc(0, 9), false, ""));
  ImageF noise = Disc(0, 3);
  for (int x = 0; x < 40; ++x) *noise.at(x, 0) = static_cast<float>(x % 9);
  EXPECT_THAT(MaskOfLevels(noise, false, "").data, ::testing::Each(0));
  EXPECT_THAT(Refusal(noise, true), HasSubstr("brightest level is 8"));
}

/// 40 x 30: black, but for noise up to a level.
Image8 NearlyBlack(int most) {
  Image8 black(40, 30, 1);
  for (std::size_t p = 0; p < black.data.size(); ++p)
    black.data[p] = static_cast<std::uint8_t>(p * 7 / 3 % (most + 1));
  return black;
}

class DrawnMask : public ::testing::Test, public TestingFolder {};

TEST_F(DrawnMask, SixteenBitsKeepALevelOfOne) {
  WriteLevels(path() / "m.png", Disc(0, 1 / 257.F), 16);
  ExpectDisc(ReadDrawnMask(path() / "m.png"));
  WriteLevels(path() / "m.tif", Disc(0, 1 / 257.F), 16);
  ExpectDisc(ReadDrawnMask(path() / "m.tif"));
}

TEST_F(DrawnMask, ANearlyBlackJpegHoldsNobody) {
  for (const int most : {1, 2, 6}) {
    WriteImage(path() / "m.jpg", NearlyBlack(most), 100);
    const ImageF levels = ReadLevels(path() / "m.jpg", 1);
    EXPECT_GT(*std::max_element(levels.data.begin(), levels.data.end()), 0) << "noise is left";
    EXPECT_THAT(ReadDrawnMask(path() / "m.jpg").data, ::testing::Each(0)) << most;
  }
  WritePng(path() / "m.png", NearlyBlack(1));
  EXPECT_EQ(ReadDrawnMask(path() / "m.png").data[1], NearlyBlack(1).data[1] ? 255 : 0);
}

TEST_F(DrawnMask, ACutOutsAlphaIsTheMask) {
  ImageF picture(40, 30, 4);
  const ImageF disc = Disc(0, 255);
  for (int p = 0; p < 40 * 30; ++p) {
    for (int c = 0; c < 3; ++c)
      picture.data[4 * p + c] = static_cast<float>((p * 7 + c * 50) % 256);
    picture.data[4 * p + 3] = disc.data[p];
  }
  WriteLevels(path() / "m.png", picture, 8);
  ExpectDisc(ReadDrawnMask(path() / "m.png"));
}

TEST_F(DrawnMask, ACutOutThatIsTransparentAllOverHoldsNobody) {
  for (const bool coloured : {false, true}) {
    Image8 picture(40, 30, 4, 180);
    for (int p = 0; p < 40 * 30; ++p) {
      for (int c = 0; coloured && c < 3; ++c)
        picture.data[4 * p + c] = static_cast<std::uint8_t>((p * 7 + c * 50) % 256);
      picture.data[4 * p + 3] = 0;
    }
    WritePng(path() / "m.png", picture);
    EXPECT_THAT(ReadDrawnMask(path() / "m.png").data, ::testing::Each(0)) << coloured;
  }
}

TEST_F(DrawnMask, WhereAlphaIsTheSameEverywhereTheLevelsCount) {
  ImageF picture(40, 30, 4, 255);
  const ImageF disc = Disc(0, 255);
  for (int p = 0; p < 40 * 30; ++p)
    for (int c = 0; c < 3; ++c) picture.data[4 * p + c] = disc.data[p];
  WriteLevels(path() / "m.png", picture, 8);
  ExpectDisc(ReadDrawnMask(path() / "m.png"));
}

TEST_F(DrawnMask, RedOnBlackIsAMaskAndAPhotographIsNone) {
  Image8 red(40, 30, 3), photograph(40, 30, 3);
  const ImageF disc = Disc(0, 255);
  for (int p = 0; p < 40 * 30; ++p) {
    red.data[3 * p] = static_cast<std::uint8_t>(disc.data[p]);
    for (int c = 0; c < 3; ++c)
      photograph.data[3 * p + c] = static_cast<std::uint8_t>((p * 7 + c * 50) % 256);
  }
  WritePng(path() / "red.png", red);
  ExpectDisc(ReadDrawnMask(path() / "red.png"));
  WritePng(path() / "photograph.png", photograph);
  EXPECT_THROW(ReadDrawnMask(path() / "photograph.png"), InputError);
}

}  // namespace keypose::drawn_mask_test
