#include "core/numbers/rotations.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/values/angles.h"

namespace keypose::rotations_test {

using Eigen::Vector3d;

Vector3d Axis() { return Vector3d(1, -2, 0.5).normalized(); }

TEST(LogOf, InvertsTheExponentialNearZeroAndNearAHalfTurn) {
  for (const double angle : {0.0, 1e-9, 1e-4, 1.0, 3.0, kPi - 1e-7}) {
    const Vector3d turn = angle * Axis();
    EXPECT_LT((LogOf(ExpOf(turn)) - turn).norm(), 1e-8) << angle;
    EXPECT_LT((LogOf(QuaternionOf(turn)) - turn).norm(), 1e-8) << angle;
  }
}

TEST(LogOf, AQuaternionAndItsNegativeAreOneRotation) {
  const Eigen::Quaterniond q = QuaternionOf(2.5 * Axis());
  EXPECT_LT((LogOf(q) - LogOf(Eigen::Quaterniond(-q.coeffs()))).norm(), 1e-14);
}

TEST(LogOf, IsNeverLongerThanAHalfTurn) {
  EXPECT_LT((LogOf(QuaternionOf(4 * Axis())) - (4 - 2 * kPi) * Axis()).norm(), 1e-12);
}

TEST(RotationDifference, IsTheSquaredSineOfHalfTheAngle) {
  const Eigen::Quaterniond a = QuaternionOf({0.3, 0.1, -0.7}), b = a * QuaternionOf(1.2 * Axis());
  EXPECT_NEAR(RotationDifference(a, b), std::sin(0.6) * std::sin(0.6), 1e-14);
  EXPECT_NEAR(AngleOfDifference(RotationDifference(a, b)), 1.2, 1e-12);
  EXPECT_NEAR(RotationDifference(a, a), 0, 1e-15);
}

TEST(TurnAfter, FollowsAnAxisThroughTwoWholeTurns) {
  Vector3d turn = Vector3d::Zero();
  Eigen::Quaterniond before = Eigen::Quaterniond::Identity();
  for (int step = 1; step <= 130; ++step) {
    const Eigen::Quaterniond next = QuaternionOf(0.1 * step * Axis());
    turn = TurnAfter(turn, before, next);
    before = next;
    ASSERT_LT((turn - 0.1 * step * Axis()).norm(), 1e-6) << step;
  }
}

}  // namespace keypose::rotations_test
