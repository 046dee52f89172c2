#include "fit/bending/view_constraints.h"

#include <gtest/gtest.h>

#include "fit/bending/testing/turned_ring.h"

namespace keypose::fit::view_constraints_test {

TEST(PullToPixel, IsZeroOnTheRayAndPullsAcrossItOnly) {
  const FitView view{0, kCamera, Ring(1)[0]};
  const Eigen::Vector3d x(0.3, 0.2, -0.1);
  const Eigen::Vector2d pixel = kCamera.Project(view.camera_from_world * x);
  const Constraint on = PullToPixel(view, 0, {0, 0, 0}, x, pixel, 2, 1);
  EXPECT_LT((on.goal - x).norm(), 1e-12);
  EXPECT_NEAR(on.q.trace(), 4, 1e-12);  // weight 2 in the two directions across
  const Eigen::Vector3d ray = (x - view.Center()).normalized();
  EXPECT_LT((on.q * ray).norm(), 1e-12);
  const Constraint off =
      PullToPixel(view, 0, {0, 0, 0}, x + Eigen::Vector3d(0, 0, 0.5), pixel, 2, 0.1);
  EXPECT_LT(off.q.trace(), 4.0 / 100);  // robust: five times the scale away
}

TEST(ScaledJacobian, IsTheDerivativeOfThePixelInUnitsOfItsFootprint) {
  const FitView view{0, kCamera, Ring(3)[1]};
  const Eigen::Vector3d x(0.4, -0.2, 0.3);
  double footprint = 0;
  const auto j = ScaledJacobian(view, x, &footprint);
  for (int k = 0; k < 3; ++k) {
    Eigen::Vector3d step = Eigen::Vector3d::Zero();
    step[k] = 1e-6;
    const Eigen::Vector2d numeric = (kCamera.Project(view.camera_from_world * (x + step)) -
                                     kCamera.Project(view.camera_from_world * (x - step))) /
                                    2e-6;
    EXPECT_LT((numeric * footprint - j.col(k)).norm(), 1e-6);
  }
}

}  // namespace keypose::fit::view_constraints_test
