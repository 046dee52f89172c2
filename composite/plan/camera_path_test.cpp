#include "composite/plan/camera_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/pictures/fit_view.h"
#include "core/values/errors.h"

namespace keypose::composite::camera_path_test {

/// A camera that swings round a figure and comes nearer, with an even acceleration.
Rigid3 SwingAt(double time) {
  const double angle = 0.1 * time + 0.004 * time * time, distance = 3 - 0.05 * time;
  return LookAt({distance * std::cos(angle), distance * std::sin(angle), 1}, {0, 0, 0.3});
}

CameraPath Swing(int knots, double apart) {
  std::vector<CameraKnot> path;
  for (int i = 0; i < knots; ++i) path.push_back({apart * i, SwingAt(apart * i)});
  return CameraPath(path);
}

/// How far [radii of the figure] two cameras see a point apart.
double Apart(const Rigid3& a, const Rigid3& b) {
  const Eigen::Vector3d point(0.2, -0.3, 0.7);
  return (a * point - b * point).norm();
}

TEST(CameraPath, KnotsAreKeptAndTheWayBetweenIsThatOfTheCamera) {
  const CameraPath path = Swing(7, 1);
  for (int i = 0; i < 7; ++i) EXPECT_LT(Apart(path.At(i), SwingAt(i)), 1e-12) << i;
  for (const double time : {0.5, 1.5, 2.25, 3.5, 5.5})
    EXPECT_LT(Apart(path.At(time), SwingAt(time)), 2e-3) << time;
  const Eigen::Vector3d chord =
      0.5 * (SwingAt(2).Inverse().translation + SwingAt(3).Inverse().translation);
  EXPECT_GT((chord - SwingAt(2.5).Inverse().translation).norm(), 5e-3)
      << "straight lines would be farther off";
  const Eigen::Quaterniond slerp = SwingAt(2).rotation.slerp(0.5, SwingAt(3).rotation);
  EXPECT_LT(slerp.angularDistance(path.At(2.5).rotation), 3e-3) << "nearly the shortest turn";
  EXPECT_LT(Apart(path.At(-2), SwingAt(0)), 1e-12) << "it stands before the first knot";
  EXPECT_LT(Apart(path.At(9), SwingAt(6)), 1e-12);
  EXPECT_LT(Apart(path.At(2 - 1e-6), path.At(2 + 1e-6)), 1e-5) << "no jump at a knot";
}

TEST(CameraPath, AnEvenMotionIsFollowedExactly) {
  std::vector<CameraKnot> knots;
  const auto at = [](double time) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.2 * time, Eigen::Vector3d::UnitZ()));
    return Rigid3{turn, Eigen::Vector3d(time, 0.5 * time * time, 1)}.Inverse();
  };
  for (const double time : {0.0, 1.0, 4.0, 5.0}) knots.push_back({time, at(time)});
  for (const double time : {0.3, 2.0, 3.0, 4.8})
    EXPECT_LT(Apart(CameraPath(knots).At(time), at(time)), 1e-12) << time;
  knots.resize(1);
  EXPECT_LT(Apart(CameraPath(knots).At(7), at(0)), 1e-12) << "one place alone is kept";
}

TEST(CameraPath, ATremblingKnotIsTold) {
  std::vector<CameraKnot> knots;
  for (int i = 0; i < 5; ++i) knots.push_back({1.0 * i, SwingAt(i)});
  EXPECT_LT(Apart(CameraPath(knots).SmoothAt(2).camera_from_world, SwingAt(2)), 1e-3);
  knots[2].camera_from_world.translation.x() += 0.05;
  const CameraPath::Smooth smooth = CameraPath(knots).SmoothAt(2);
  EXPECT_NEAR(Apart(smooth.camera_from_world, knots[2].camera_from_world), 0.05, 1e-3);
  EXPECT_NEAR(smooth.gain, std::sqrt(1 + 2 * (16 + 1) / 36.0), 1e-12);
}

TEST(CameraPath, KnotsMustBeInOrder) {
  EXPECT_THROW(CameraPath({}), InputError);
  EXPECT_THROW(CameraPath({{1, {}}, {1, {}}}), InputError);
}

}  // namespace keypose::composite::camera_path_test
