#include "core/pictures/srgb16.h"

#include <gtest/gtest.h>

#include "core/pictures/srgb.h"

namespace keypose::srgb16_test {

TEST(Srgb16, EachOf65536ValuesComesBack) {
  const float* linear = LinearTable16();
  for (int i = 0; i < 65536; ++i) ASSERT_EQ(Srgb16Of(linear[i]), i);
}

TEST(Srgb16, ValuesOfEightBitsHaveTheSameLight) {
  for (int i = 0; i < 256; ++i)
    ASSERT_EQ(LinearTable16()[257 * i], LinearOf(static_cast<std::uint8_t>(i))) << i;
}

TEST(SrgbFraction, IsRightToAHundredthOfAStep) {
  for (int i = 0; i < 65536; ++i)
    ASSERT_NEAR(65535.0 * SrgbFraction(LinearTable16()[i]), i, 0.011) << i;
  EXPECT_NEAR(SrgbFraction(0.2140411f), 0.5, 1e-6);
  EXPECT_FLOAT_EQ(SrgbFraction(0.002f), 0.02584f);
  EXPECT_EQ(SrgbFraction(-0.1f), 0);
  EXPECT_NEAR(SrgbFraction(7), 1, 1e-6);
}

TEST(Srgb16, LightOutsideTheRangeIsClamped) {
  EXPECT_EQ(Srgb16Of(-0.1f), 0);
  EXPECT_EQ(Srgb16Of(7.0f), 65535);
  EXPECT_NEAR(Srgb16Of(0.2140411f), 32767.5, 0.5) << "sRGB 0.5";
}

}  // namespace keypose::srgb16_test
