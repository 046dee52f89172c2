#include "interpolate/timing/easing.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/io/project/timeline_json.h"
#include "interpolate/timing/spline.h"

namespace keypose::interpolation::easing_test {

TEST(EaseAt, KnownCurvesAndExactEnds) {
  const Ease in_out = EaseNamed("in-out").value();
  EXPECT_EQ(EaseAt(in_out, 0), 0);
  EXPECT_EQ(EaseAt(in_out, 1), 1);
  EXPECT_NEAR(EaseAt(in_out, 0.5), 0.5, 1e-12);  // symmetric
  EXPECT_NEAR(EaseAt(in_out, 0.2) + EaseAt(in_out, 0.8), 1, 1e-12);
  EXPECT_LT(EaseAt(in_out, 0.1), 0.03);
  EXPECT_EQ(EaseAt({}, 0.3), 0.3);
  // With x(u) = u the curve is its own polynomial: y = 3 u (1-u)^2 y1 + 3 u^2 (1-u) y2 + u^3.
  const double u = 0.4;
  EXPECT_NEAR(EaseAt({1.0 / 3, 0.9, 2.0 / 3, 0.2}, u),
              3 * u * (1 - u) * (1 - u) * 0.9 + 3 * u * u * (1 - u) * 0.2 + u * u * u, 1e-12);
  EXPECT_LT(EaseAt({0.4, -0.8, 0.6, 1}, 0.2), 0);  // moves backwards first
}

TEST(EaseAt, SlopesAreTheDerivativesAtTheEnds) {
  const double h = 1e-6;
  for (const Ease& ease : {Ease{}, Ease{0.3, 0.1, 0.6, 0.8}, Ease{0.42, 0, 0.58, 1},
                           Ease{0, 0, 0.5, 0.7}, Ease{0.2, 0.3, 1, 1}}) {
    EXPECT_NEAR(SlopeAtStart(ease), EaseAt(ease, h) / h, 1e-3);
    EXPECT_NEAR(SlopeAtEnd(ease), (1 - EaseAt(ease, 1 - h)) / h, 1e-3);
  }
}

TEST(VelocityAtKey, ClampedIsTheHarmonicMeanAndNeverSwingsBeyond) {
  EXPECT_NEAR(VelocityAtKey(1.0, 2.0, 1, 1, false), 2 / (1 / 1.0 + 1 / 2.0), 1e-12);
  EXPECT_EQ(VelocityAtKey(1.0, -2.0, 1, 1, false), 0);
  EXPECT_EQ(VelocityAtKey(0.0, 3.0, 1, 1, false), 0);
  EXPECT_NEAR(VelocityAtKey(1.0, 2.0, 1, 3, true), (3 * 1.0 + 1 * 2.0) / 4, 1e-12);
  EXPECT_EQ(VelocityAtKey(0.0, 3.0, 1, 1, true), 0);
}

TEST(VelocityAtKey, DoesNotDependOnTheBasisOrTheDirectionOfTime) {
  const Eigen::Vector3d a(1, 0.2, -0.3), b(0.7, 0.9, 0.1);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Vector3d v = VelocityAtKey(a, b, 2, 3, false);
  EXPECT_LT(
      (VelocityAtKey(Eigen::Vector3d(turn * a), Eigen::Vector3d(turn * b), 2, 3, false) - turn * v)
          .norm(),
      1e-14);
  EXPECT_LT((VelocityAtKey(Eigen::Vector3d(-b), Eigen::Vector3d(-a), 3, 2, false) + v).norm(),
            1e-14);
}

}  // namespace keypose::interpolation::easing_test
