// Mattes by a clean plate and by colours.
#include "composite/locating/mattes/mattes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/pictures/mask_overlap.h"
#include "core/values/image.h"

namespace keypose::composite::mattes_test {

auto FigurePixels(const Image8& matte) {
  return std::count_if(matte.data.begin(), matte.data.end(), [](int value) { return value > 127; });
}

TEST(MatteFromPlate, LeavesOutShadowsAndFindsNothingInAnEmptySet) {
  Image8 plate(200, 150, 3);
  for (int y = 0; y < 150; ++y)
    for (int x = 0; x < 200; ++x) {
      std::uint8_t* p = plate.at(x, y);
      p[0] = static_cast<std::uint8_t>(100 + x / 4), p[1] = 120,
      p[2] = static_cast<std::uint8_t>(90 + y / 4);
    }
  EXPECT_EQ(FigurePixels(MatteFromPlate(plate, plate)), 0);
  Image8 frame = plate;
  for (int y = 40; y < 90; ++y)
    for (int x = 60; x < 120; ++x) {
      std::uint8_t* p = frame.at(x, y);
      p[0] = 200, p[1] = 60, p[2] = 50;
    }
  for (int y = 90; y < 110; ++y)
    for (int x = 60; x < 150; ++x)
      for (int c = 0; c < 3; ++c)
        frame.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(0.75 * plate.at(x, y)[c]));
  const Image8 matte = MatteFromPlate(frame, plate);
  EXPECT_NEAR(FigurePixels(matte), 50 * 60, 60);
  EXPECT_EQ(*matte.at(90, 65), 255);
  EXPECT_EQ(*matte.at(100, 100), 0);
}

TEST(MatteByColours, FollowsTheFigureWhereTheMeshIsOff) {
  Image8 truth(300, 300, 1), off(300, 300, 1);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 300; ++x) {
      if (std::hypot(x - 150.0, y - 150.0) < 60) *truth.at(x, y) = 255;
      if (std::hypot(x - 154.0, y - 147.0) < 60) *off.at(x, y) = 255;
    }
  Image8 picture(300, 300, 3);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 300; ++x)
      for (int c = 0; c < 3; ++c)
        picture.at(x, y)[c] = static_cast<std::uint8_t>(
            (*truth.at(x, y) ? 170 - 40 * c : 60 + 20 * c) + (7 * x + 13 * y) % 9);
  EXPECT_LT(MaskIoU(off, truth), 0.93);
  EXPECT_GT(MaskIoU(MatteByColours(picture, off, 10), truth), 0.98);
}

}  // namespace keypose::composite::mattes_test
