#include "views/decode/film_turn.h"

#include <gtest/gtest.h>

namespace keypose::film_turn_test {

constexpr std::int32_t kOne = 1 << 16, kUnit = 1 << 30;

DisplayMatrix Matrix(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
  return {a, b, 0, c, d, 0, 0, 0, kUnit};
}

TEST(OrientationOf, AllQuarterTurnsAndTheirMirrors) {
  EXPECT_EQ(OrientationOf(Matrix(kOne, 0, 0, kOne)), 1);
  EXPECT_EQ(OrientationOf(Matrix(-kOne, 0, 0, kOne)), 2);
  EXPECT_EQ(OrientationOf(Matrix(-kOne, 0, 0, -kOne)), 3);
  EXPECT_EQ(OrientationOf(Matrix(kOne, 0, 0, -kOne)), 4);
  EXPECT_EQ(OrientationOf(Matrix(0, kOne, kOne, 0)), 5);
  EXPECT_EQ(OrientationOf(Matrix(0, kOne, -kOne, 0)), 6) << "as telephones film upright";
  EXPECT_EQ(OrientationOf(Matrix(0, -kOne, -kOne, 0)), 7);
  EXPECT_EQ(OrientationOf(Matrix(0, -kOne, kOne, 0)), 8);
}

TEST(OrientationOf, ScaledMatricesTurnAsWell) {
  EXPECT_EQ(OrientationOf(Matrix(0, 2 * kOne, -2 * kOne, 0)), 6);
  EXPECT_EQ(OrientationOf(Matrix(3, 65534, -65534, 3)), 6) << "rounded";
}

TEST(OrientationOf, OtherAnglesAndEmptyMatricesAreNone) {
  const DisplayMatrix slanted = Matrix(56756, 32768, -32768, 56756);
  EXPECT_FALSE(OrientationOf(slanted));
  EXPECT_NEAR(TurnOf(slanted), 30, 0.01);
  EXPECT_FALSE(OrientationOf(Matrix(0, 0, 0, 0)));
  EXPECT_FALSE(OrientationOf(Matrix(kOne, 0, kOne, kOne))) << "sheared";
}

}  // namespace keypose::film_turn_test
