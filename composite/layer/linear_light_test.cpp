#include "composite/layer/linear_light.h"

#include <gtest/gtest.h>

#include <cmath>

namespace keypose::composite::linear_light_test {

TEST(LinearLight, EveryStoredLevelComesBack) {
  Image8 levels(256, 1, 1);
  for (int i = 0; i < 256; ++i) *levels.at(i, 0) = static_cast<std::uint8_t>(i);
  EXPECT_EQ(SrgbOf(LinearOf(levels)).data, levels.data);
}

TEST(LinearLight, BlurKeepsTheSumAndASpotsWidth) {
  ImageF spot(41, 41, 1);
  *spot.at(20, 20) = 100;
  const ImageF blurred = Blurred(spot, 2);
  double sum = 0, spread = 0;
  for (int y = 0; y < 41; ++y)
    for (int x = 0; x < 41; ++x)
      sum += *blurred.at(x, y), spread += *blurred.at(x, y) * (x - 20) * (x - 20);
  EXPECT_NEAR(sum, 100, 1e-3);
  EXPECT_NEAR(std::sqrt(spread / sum), 2, 0.05);
  EXPECT_EQ(Blurred(spot, 0).data, spot.data);
}

}  // namespace keypose::composite::linear_light_test
