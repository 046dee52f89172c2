#include "core/pictures/fit_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/values/errors.h"

namespace keypose::fit_view_test {

TEST(LookAt, TargetIsAheadAndUpIsUpwards) {
  const Eigen::Vector3d eye(3, -2, 1), target(0.5, 0.2, -0.3);
  const Rigid3 camera_from_world = LookAt(eye, target);
  const Eigen::Vector3d ahead = camera_from_world * target;
  EXPECT_NEAR(ahead.x(), 0, 1e-12);
  EXPECT_NEAR(ahead.y(), 0, 1e-12);
  EXPECT_NEAR(ahead.z(), (target - eye).norm(), 1e-12);
  EXPECT_NEAR((camera_from_world * eye).norm(), 0, 1e-12);
  EXPECT_LT((camera_from_world * (target + Eigen::Vector3d(0, 0, 0.1))).y(), 0);  // y is down
  EXPECT_THROW(LookAt(eye, eye), InputError);
}

TEST(FitView, HoldsEveryPointAndFillsThePicture) {
  PointsX3 points(3, 3);
  points << 0, 0, 0, 5, 1, 0, 1, 2, 9;
  for (const double azimuth : {0.0, 77.0, 200.0}) {
    const View view = FitView(points, azimuth, 20, 320, 200);
    double most = 0;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector2d p = view.Project(points.row(i));
      EXPECT_GT(p.minCoeff(), 0);
      EXPECT_LT(p.x(), 320);
      EXPECT_LT(p.y(), 200);
      most = std::max({most, std::abs(p.x() / 160 - 1), std::abs(p.y() / 100 - 1)});
    }
    EXPECT_GT(most, 0.85);
  }
}

TEST(FitView, AzimuthZeroSeesTheFrontAndNinetyTheRight) {
  PointsX3 points(2, 3);
  points << -1, -1, -1, 1, 1, 1;
  EXPECT_LT(FitView(points, 0, 0, 10, 10).Center().y(), -1);
  EXPECT_GT(FitView(points, 90, 0, 10, 10).Center().x(), 1);
  EXPECT_GT(FitView(points, 0, 60, 10, 10).Center().z(), 1);
  EXPECT_THROW(FitView(PointsX3(0, 3), 0, 0, 10, 10), InputError);
}

}  // namespace keypose::fit_view_test
