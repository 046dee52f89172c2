#include "capture/pictures/strangers.h"

#include <gtest/gtest.h>

#include "capture/testing/test_images.h"

namespace keypose::capture::strangers_test {

constexpr int kWidth = 180, kHeight = 120;

std::vector<Image8> Ring(int count, TestWall wall, int from = 0) {
  std::vector<Image8> ring;
  for (int i = 0; i < count; ++i)
    ring.push_back(MakeTestPhoto(from + i, kWidth, kHeight, wall).image);
  return ring;
}

std::vector<ColourSketch> Sketches(const std::vector<Image8>& pictures) {
  std::vector<ColourSketch> sketches;
  for (const Image8& picture : pictures) sketches.push_back(SketchOf(picture));
  return sketches;
}

std::vector<std::vector<std::size_t>> Things(const std::vector<Image8>& pictures) {
  return ThingsShown(pictures, Sketches(pictures));
}

Image8 OneColour(std::uint8_t red, std::uint8_t green, std::uint8_t blue) {
  Image8 image(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const std::uint8_t colour[3] = {red, green, blue};
      std::copy_n(colour, 3, image.at(x, y));
    }
  return image;
}

TEST(SketchOf, SharesSumToOneAndAPlainPictureHasNoColourOfItsOwn) {
  const ColourSketch plain = SketchOf(OneColour(90, 140, 60)),
                     figure = SketchOf(Ring(1, TestWall::kDark)[0]);
  double sum = 0;
  for (const auto& [colour, share] : figure.middle) sum += share;
  EXPECT_NEAR(sum, 1, 1e-4) << "of single precision";
  EXPECT_NEAR(plain.own_share, 0, 1e-4);
  EXPECT_GT(figure.own_share, 0.3);
}

TEST(Unlikeness, OfOnePictureIsZeroAndOfTwoPlainColoursTheLargest) {
  const ColourSketch green = SketchOf(OneColour(40, 160, 50)),
                     red = SketchOf(OneColour(200, 30, 30));
  EXPECT_NEAR(Unlikeness(green, green), 0, 1e-4);
  EXPECT_NEAR(Unlikeness(green, red), 1 / 0.56, 1e-3);
  EXPECT_EQ(Unlikeness(green, red), Unlikeness(red, green));
}

TEST(ThingsShown, RingOfOneFigureIsOneThing) {
  const auto things = Things(Ring(12, TestWall::kLight));
  ASSERT_EQ(things.size(), 1U);
  EXPECT_EQ(things[0].size(), 12U);
}

TEST(ThingsShown, FigureOfOtherColoursOnTheSameSetIsAnotherThing) {
  std::vector<Image8> pictures = Ring(12, TestWall::kDark);
  pictures[5] = MakeTestStranger(5, kWidth, kHeight, TestWall::kDark);
  const auto things = Things(pictures);
  ASSERT_EQ(things.size(), 2U);
  EXPECT_EQ(things[0].size(), 11U);
  EXPECT_EQ(things[1], std::vector<std::size_t>{5});
}

TEST(ThingsShown, EmptySetIsAnotherThing) {
  std::vector<Image8> pictures = Ring(12, TestWall::kDark);
  pictures.push_back(MakeTestWall(kWidth, kHeight, TestWall::kDark));
  const auto things = Things(pictures);
  ASSERT_EQ(things.size(), 2U);
  EXPECT_EQ(things[1], std::vector<std::size_t>{12});
}

TEST(ThingsShown, TwoRingsAreTwoThings) {
  std::vector<Image8> pictures = Ring(8, TestWall::kDark);
  for (int i = 0; i < 5; ++i)
    pictures.push_back(MakeTestStranger(20 + i, kWidth, kHeight, TestWall::kDark));
  const auto things = Things(pictures);
  ASSERT_EQ(things.size(), 2U);
  EXPECT_EQ(things[0], (std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(things[1], (std::vector<std::size_t>{8, 9, 10, 11, 12}));
}

/// Patches of random brightness in one tint; `shift` moves them.
Image8 Patches(int shift, double red, double blue) {
  Image8 image(240, 160, 3);
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 240; ++x) {
      const std::uint32_t cell = static_cast<std::uint32_t>((x + shift) / 7) * 73856093U ^
                                 static_cast<std::uint32_t>(y / 7) * 19349663U;
      const double level =
          60 + static_cast<double>(((cell ^ (cell >> 13)) * 0x5bd1e995U) >> 15 & 127);
      image.at(x, y)[0] = static_cast<std::uint8_t>(red * level);
      image.at(x, y)[1] = static_cast<std::uint8_t>(0.6 * level);
      image.at(x, y)[2] = static_cast<std::uint8_t>(blue * level);
    }
  return image;
}

TEST(ThingsShown, SharedPlacesOutweighOtherColoursUnlessTheyStandStill) {
  const auto with = [](int shift) {
    std::vector<Image8> pictures;
    for (int i = 0; i < 4; ++i) pictures.push_back(Patches(i, 1, 0.3));
    pictures.push_back(Patches(shift, 0.3, 1));
    return pictures;
  };
  EXPECT_EQ(Things(with(12)).size(), 1U);
  EXPECT_EQ(Things(with(0)).size(), 1U) << "it has moved against the others, if not the first";
  std::vector<Image8> still(4, Patches(0, 1, 0.3));
  still.push_back(Patches(0, 0.3, 1));
  EXPECT_EQ(Things(still).size(), 2U);
}

/// A chequered board before a grey wall, with a ball on it, and where the board's print shows.
struct OnBoard {
  Image8 image{kWidth, kHeight, 3, 120}, print{kWidth, kHeight, 1, 0};
};

OnBoard BallOnBoard(int turn, std::uint8_t red, std::uint8_t green, std::uint8_t blue) {
  OnBoard photo;
  for (int y = 20; y < 100; ++y)
    for (int x = 30; x < 150; ++x) {
      const int fx = x - 90, fy = y - 60;
      const bool ball = fx * fx + fy * fy < 15 * 15;
      const std::uint8_t ink = ((x + turn) / 6 + y / 6) % 2 ? 30 : 220;
      const std::uint8_t colour[3] = {ball ? red : ink, ball ? green : ink, ball ? blue : ink};
      std::copy_n(colour, 3, photo.image.at(x, y));
      *photo.print.at(x, y) = ball ? 0 : 255;
    }
  return photo;
}

TEST(ThingsShown, OnABoardTheFiguresAreComparedAndNotTheirPrint) {
  std::vector<Image8> pictures, prints;
  std::vector<ColourSketch> with, without;
  for (int i = 0; i < 9; ++i) {
    const OnBoard photo = i == 4 ? BallOnBoard(i, 40, 60, 190) : BallOnBoard(i, 190, 60, 40);
    pictures.push_back(photo.image);
    prints.push_back(photo.print);
    with.push_back(SketchOf(photo.image));
    without.push_back(SketchOf(photo.image, photo.print));
  }
  EXPECT_LT(Unlikeness(with[3], with[4]), 1) << "most of both is one board";
  EXPECT_GT(Unlikeness(without[3], without[4]), 1);
  EXPECT_LT(Unlikeness(without[3], without[5]), 0.1);
  const auto things = ThingsShown(pictures, without, prints);
  ASSERT_EQ(things.size(), 2U);
  EXPECT_EQ(things[1], std::vector<std::size_t>{4});
}

TEST(SameViews, ViewWithOtherNoiseIsThereTwiceAndNeighboursAreNot) {
  std::vector<Image8> pictures = Ring(10, TestWall::kDark);
  pictures.push_back(pictures[3]);
  for (std::size_t k = 0; k < pictures[10].data.size(); ++k)
    pictures[10].data[k] = static_cast<std::uint8_t>(pictures[10].data[k] ^ (k * 7 % 3 == 0));
  const auto same = SameViews(pictures, Sketches(pictures));
  ASSERT_EQ(same.size(), 1U);
  EXPECT_EQ(same[0], (std::pair<std::size_t, std::size_t>{3, 10}));
}

TEST(SameViews, FigureThatLooksTheSameFromAllSidesIsNotThereTwice) {
  std::vector<Image8> vase(9, Patches(0, 1, 0.5));
  for (std::size_t i = 0; i < vase.size(); ++i) vase[i].data[3 * i] ^= 1;
  EXPECT_TRUE(SameViews(vase, Sketches(vase)).empty());
}

}  // namespace keypose::capture::strangers_test
