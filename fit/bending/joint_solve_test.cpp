#include "fit/bending/joint_solve.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/surfaces/shapes.h"
#include "fit/bending/testing/turned_ring.h"

namespace keypose::fit::joint_solve_test {

Rigid3 Turned(const Rigid3& pose, double angle, const Eigen::Vector3d& shift) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, -1).normalized()));
  return {turn * pose.rotation, turn * pose.translation + shift};
}

TEST(SolveJointly, FindsShiftedCamerasOfARigidShape) {
  const Mesh sphere = MakeIcosphere(3);
  const std::vector<Rigid3> truth = Ring(4);
  std::vector<Rigid3> poses = truth;
  poses[1] = Turned(poses[1], 0.03, {0.05, -0.04, 0.1});
  poses[3] = Turned(poses[3], -0.02, {-0.03, 0.06, -0.08});
  ArapFit fit(sphere.points, sphere.faces, {}, 0.01);
  fit.SetMaps(std::vector<Eigen::Matrix3d>(sphere.vertex_count(), Eigen::Matrix3d::Identity()));
  PointsX3 points = sphere.points;
  for (int round = 0; round < 30; ++round) {
    std::vector<LevelConstraint> constraints;
    for (int v = 0; v < 4; ++v)
      for (int i = 0; i < sphere.vertex_count(); i += 3) {
        const Eigen::Vector2d pixel = kCamera.Project(truth[v] * sphere.points.row(i).transpose());
        const Constraint c = PullToPixel({v, kCamera, poses[v]}, i, {0, 0, 0},
                                         points.row(i).transpose(), pixel, 1, 10);
        constraints.push_back({v, i, {0, 0, 0}, c.q, c.goal});
      }
    points = SolveJointly(fit, points, constraints, Pulls(points.rows()), 1e-3, poses);
    fit.FitMaps(points);
  }
  // The gauge is free: compare what each camera sees, and the shape.
  double worst_px = 0;
  for (int v = 0; v < 4; ++v)
    for (int i = 0; i < sphere.vertex_count(); i += 7)
      worst_px = std::max(worst_px, (kCamera.Project(poses[v] * points.row(i).transpose()) -
                                     kCamera.Project(truth[v] * sphere.points.row(i).transpose()))
                                        .norm());
  EXPECT_LT(worst_px, 0.02);
  const Similarity3 back = FitSimilarity(points, sphere.points);
  EXPECT_LT((Transformed(back, points) - sphere.points).rowwise().norm().maxCoeff(), 1e-3);
}

TEST(SolveJointly, APullOfNoCameraIsAmongThePullsOnly) {
  const Mesh sphere = MakeIcosphere(2);
  ArapFit fit(sphere.points, sphere.faces, {}, 0.01);
  fit.SetMaps(std::vector<Eigen::Matrix3d>(sphere.vertex_count(), Eigen::Matrix3d::Identity()));
  std::vector<Rigid3> with = Ring(2), without = Ring(2);
  std::vector<LevelConstraint> constraints;
  for (int v = 0; v < 2; ++v)
    for (int i = 0; i < sphere.vertex_count(); i += 3) {
      const Eigen::Vector3d x = sphere.points.row(i).transpose();
      const Constraint c =
          PullToPixel({v, kCamera, with[v]}, i, {0, 0, 0}, x, kCamera.Project(with[v] * x), 1, 10);
      constraints.push_back({v, i, {0, 0, 0}, c.q, c.goal});
    }
  Pulls pulls(sphere.points.rows());
  pulls.q[5] = Eigen::Matrix3d::Identity();
  pulls.b.row(5) = 1.1 * sphere.points.row(5);
  const PointsX3 expected = SolveJointly(fit, sphere.points, constraints, pulls, 1e-3, without);
  constraints.push_back({-1, 5, {0, 0, 0}, pulls.q[5], 1.1 * sphere.points.row(5).transpose()});
  EXPECT_EQ(SolveJointly(fit, sphere.points, constraints, pulls, 1e-3, with), expected);
  EXPECT_GT((expected - sphere.points).row(5).norm(), 0.01);
}

}  // namespace keypose::fit::joint_solve_test
