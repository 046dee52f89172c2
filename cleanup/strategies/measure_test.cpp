#include "cleanup/strategies/measure.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cleanup/strategies/cleanup_result.h"
#include "core/surfaces/shapes.h"

namespace keypose::cleanup::measure_test {

TEST(LeastAngleDeg, IsThatOfTheThinnestFace) {
  EXPECT_NEAR(LeastAngleDeg(MakeBox(1, 1, 1)), 45, 1e-9);
  EXPECT_NEAR(LeastAngleDeg(MakeBox(3, 1, 1)), std::atan(1.0 / 3) * 180 / EIGEN_PI, 1e-9);
}

TEST(MeasureDistances, AShellOfAnotherSizeLiesItsDifferenceAway) {
  const double radius = 1 / (2 * std::sqrt(3.0));  // its box has a diagonal of 1
  Mesh ball = MakeIcosphere(4);
  ball.points *= radius;
  Mesh shell = ball;
  shell.points *= 1.01;
  CleanupResult result;
  MeasureDistances(shell, ball, ball, result);
  const double expected = 0.01 * radius;
  EXPECT_NEAR(result.from_input.p99, expected, 0.1 * expected);
  EXPECT_NEAR(result.to_input.p99, expected, 0.1 * expected);
}

}  // namespace keypose::cleanup::measure_test
