#include "synth/rooms/print.h"

#include <gtest/gtest.h>

namespace keypose::synth::print_test {

Image8 Steps() {  // four columns: black, white, black, white
  Image8 image(4, 2, 3);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = x % 2 ? 255 : 0;
  return image;
}

TEST(Print, MiddleOfAPixelHasItsLightAndFarAwayAllAreMixed) {
  const Print print(Steps(), 0.4);
  EXPECT_NEAR(print.At(0.15, 0.05, 1e-4)[0], 1, 1e-6);
  EXPECT_NEAR(print.At(0.25, 0.05, 1e-4)[0], 0, 1e-6);
  EXPECT_NEAR(print.height_m(), 0.2, 1e-12);
  // Half of the light is sRGB 188, of which a byte is the nearest.
  EXPECT_NEAR(print.At(0.2, 0.1, 10)[1], 0.5, 0.003);
}

TEST(Print, BeyondItsBorderItEndsOrRepeats) {
  EXPECT_NEAR(Print(Steps(), 0.4).At(-0.35, 0.05, 1e-4)[0], 0, 1e-6);
  EXPECT_NEAR(Print(Steps(), 0.4, true).At(-0.25, 0.05, 1e-4)[0], 1, 1e-6);
  EXPECT_NEAR(Print(Steps(), 0.4, true).At(0.55, 0.05, 1e-4)[0], 1, 1e-6);
}

}  // namespace keypose::synth::print_test
