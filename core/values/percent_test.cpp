#include "core/values/percent.h"

#include <gtest/gtest.h>

namespace keypose::percent_test {

TEST(Percent, IsWhole) {
  EXPECT_EQ(PercentHalfUp(0), "0 %");
  EXPECT_EQ(PercentHalfUp(0.4567), "46 %");
  EXPECT_EQ(PercentHalfUp(1.5), "150 %");
  EXPECT_EQ(PercentHalfEven(0), "0 %");
  EXPECT_EQ(PercentHalfEven(0.4567), "46 %");
  EXPECT_EQ(PercentHalfEven(1.5), "150 %");
}

TEST(Percent, RoundsHalvesAsItsNameSays) {
  EXPECT_EQ(PercentHalfUp(0.125), "13 %");
  EXPECT_EQ(PercentHalfUp(0.375), "38 %");
  EXPECT_EQ(PercentHalfUp(-0.125), "-13 %");
  EXPECT_EQ(PercentHalfEven(0.125), "12 %");
  EXPECT_EQ(PercentHalfEven(0.375), "38 %");
}

}  // namespace keypose::percent_test
