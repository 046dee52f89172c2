#include "capture/pictures/own_masks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/pictures/given_matte.h"
#include "core/pictures/image_turns.h"
#include "core/values/errors.h"

namespace keypose::capture::own_masks_test {

/// A block of the figure near the upper left corner.
Image8 Corner(int width, int height) {
  Image8 mask(width, height, 1);
  for (int y = height / 8; y < height / 2; ++y)
    for (int x = width / 8; x < width / 4; ++x) *mask.at(x, y) = 255;
  return mask;
}

TEST(PlacedMask, OfThePhotographsSizeStaysAsItIs) {
  MaskChange change;
  EXPECT_EQ(PlacedMask(Corner(80, 48), {80, 48, 6, "m", "p"}, &change).data, Corner(80, 48).data);
  EXPECT_FALSE(change.turned || change.enlarged);
}

TEST(PlacedMask, AsStoredIsTurnedAsThePhotographIs) {
  for (const int orientation : {5, 6, 7, 8}) {
    MaskChange change;
    const Image8 stored = Corner(80, 48);
    const Image8 placed = PlacedMask(stored, {48, 80, orientation, "m", "p"}, &change);
    EXPECT_EQ(placed.data, Oriented(stored, orientation).data);
    EXPECT_TRUE(change.turned);
    EXPECT_FALSE(change.enlarged);
  }
}

TEST(PlacedMask, OfHalfTheSizeIsEnlargedAlsoWhenAsStored) {
  MaskChange change;
  EXPECT_EQ(PlacedMask(Corner(40, 24), {80, 48, 1, "m", "p"}, &change).data, Corner(80, 48).data);
  EXPECT_TRUE(change.enlarged);
  const Image8 turned = PlacedMask(Corner(40, 24), {48, 80, 6, "m", "p"}, &change);
  EXPECT_EQ(turned.data, Oriented(Corner(80, 48), 6).data);
  EXPECT_TRUE(change.enlarged && change.turned);
  // An odd side is rounded when it is halved.
  EXPECT_NO_THROW(PlacedMask(Corner(40, 24), {81, 49, 1, "m", "p"}, nullptr));
}

TEST(PlacedMask, OfAnotherShapeIsRefusedWithBothSizes) {
  EXPECT_THROW(PlacedMask(Corner(48, 80), {80, 48, 1, "m", "p"}, nullptr), InputError);
  EXPECT_THROW(PlacedMask(Corner(80, 48), {800, 480, 1, "m", "p"}, nullptr), InputError)
      << "a tenth";
  try {
    PlacedMask(Corner(60, 48), {80, 48, 1, "m.png", "p.jpg"}, nullptr);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("m.png is 60 x 48, but p.jpg is 80 x 48"));
  }
}

TEST(SideOf, TellsTheFigureFromWhatIsRoundIt) {
  EXPECT_EQ(SideOf(Corner(80, 48)), MaskSide::kFigure);
  EXPECT_EQ(SideOf(InvertedMatte(Corner(80, 48))), MaskSide::kSurroundings);
  EXPECT_EQ(SideOf(Image8(80, 48, 1)), MaskSide::kNothing);
  EXPECT_EQ(SideOf(Image8(80, 48, 1, 255)), MaskSide::kFigure) << "it fills the picture";
  // A figure that leaves the picture below and at the sides.
  Image8 close(80, 48, 1);
  for (int y = 10; y < 48; ++y)
    for (int x = 0; x < 80; ++x) *close.at(x, y) = 255;
  EXPECT_EQ(SideOf(close), MaskSide::kFigure);
}

TEST(BorderContrast, IsHighWhereTheMaskLiesOnTheFigure) {
  const Image8 mask = Corner(80, 48);
  Image8 grey(80, 48, 1, 200);
  for (std::size_t p = 0; p < grey.data.size(); ++p)
    if (mask.data[p]) grey.data[p] = 60;
  EXPECT_EQ(BorderContrast(grey, mask), 140);
  EXPECT_LT(BorderContrast(grey, TurnedOver(mask)), 1);
  EXPECT_EQ(BorderContrast(grey, Image8(80, 48, 1)), 0);
}

}  // namespace keypose::capture::own_masks_test
