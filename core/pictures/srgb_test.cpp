#include "core/pictures/srgb.h"

#include <gtest/gtest.h>

namespace keypose::srgb_test {

TEST(Srgb, HasTheValuesOfTheStandard) {
  EXPECT_EQ(LinearFromSrgb(0), 0);
  EXPECT_NEAR(LinearFromSrgb(1), 1, 1e-15);
  EXPECT_NEAR(LinearFromSrgb(0.04), 0.04 / 12.92, 1e-15);
  EXPECT_NEAR(LinearFromSrgb(0.5), 0.21404114, 1e-8);
  EXPECT_NEAR(SrgbFromLinear(0.21404114), 0.5, 1e-8);
}

TEST(Srgb, TablesHoldTheFormula) {
  for (int i = 0; i < 256; ++i) {
    EXPECT_EQ(kLinearDouble[i], LinearFromSrgb(i / 255.0));
    EXPECT_EQ(LinearOf(static_cast<std::uint8_t>(i)),
              static_cast<float>(LinearFromSrgb(i / 255.0)));
  }
}

TEST(Srgb, BytesComeBack) {
  for (int i = 0; i < 256; ++i) EXPECT_EQ(SrgbOf(LinearOf(static_cast<std::uint8_t>(i))), i);
}

TEST(Srgb, ValuesOutsideAreClamped) {
  EXPECT_EQ(SrgbOf(-1), 0);
  EXPECT_EQ(SrgbOf(2), 255);
}

}  // namespace keypose::srgb_test
