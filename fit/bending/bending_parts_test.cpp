// Constraints, filters, the solver for positions and cameras, and flipped faces.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/pictures/render.h"
#include "core/surfaces/shapes.h"
#include "fit/bending/feature_filter.h"
#include "fit/bending/joint_solve.h"
#include "fit/bending/unfold.h"
#include "views/placement/picture_pose.h"

namespace keypose::fit::bending_parts_test {

const Pinhole kCamera{800, 800, 1000, 1000, 400, 400};

std::vector<Rigid3> Ring(int count) {
  std::vector<Rigid3> poses;
  for (int i = 0; i < count; ++i) {
    const double a = 2 * M_PI * i / count;
    poses.push_back(LookAt({6 * std::cos(a), 6 * std::sin(a), 2}, {0, 0, 0}));
  }
  return poses;
}

Rigid3 Turned(const Rigid3& pose, double angle, const Eigen::Vector3d& shift) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, -1).normalized()));
  return {turn * pose.rotation, turn * pose.translation + shift};
}

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

TEST(Unfold, TurnsAFlippedFaceBackAndLeavesTheRest) {
  const Mesh sphere = MakeIcosphere(3);
  PointsX3 points = sphere.points;
  points.row(20) *= 0.2;  // pushed through its fan
  const PointsX3 before = points;
  const std::vector<Eigen::Matrix3d> maps(sphere.vertex_count(), Eigen::Matrix3d::Identity());
  const auto flipped = [&] { return FlippedFaces(sphere.points, sphere.faces, maps, points); };
  EXPECT_GT(flipped(), 2);
  const int moved = Unfold(sphere.points, sphere.faces, maps, points);
  EXPECT_EQ(flipped(), 0);
  EXPECT_GT(moved, 0);
  EXPECT_LT(moved, 60);
  EXPECT_LT((points.row(20) - sphere.points.row(20)).norm(), 0.05);
  int changed = 0;
  for (Eigen::Index v = 0; v < points.rows(); ++v) changed += points.row(v) != before.row(v);
  EXPECT_LE(changed, moved);
  PointsX3 good = sphere.points;
  EXPECT_EQ(Unfold(sphere.points, sphere.faces, maps, good), 0);
}

/// Matches of a plane of places, of which every fifth shows another place.
std::vector<FeatureMatch> PlaneMatches(const PointsX3& points, const Rigid3& pose) {
  std::vector<FeatureMatch> matches;
  std::mt19937 random(7);
  for (int i = 0; i < points.rows(); ++i) {
    FeatureMatch match;
    match.point.vertices = {i, i, i};
    match.pixel = kCamera.Project(pose * points.row(i).transpose());
    if (i % 5 == 0) match.pixel = Eigen::Vector2d(random() % 800, random() % 800);
    matches.push_back(match);
  }
  return matches;
}

PointsX3 Patch() {
  PointsX3 points(400, 3);
  for (int i = 0; i < 400; ++i) {
    const double x = (i % 20) / 10.0 - 1, y = static_cast<double>(i / 20) / 10 - 1;
    points.row(i) << x, y, 0.3 * std::sin(2 * x) * std::cos(2 * y);
  }
  return points;
}

TEST(ConsistentMatches, KeepsThoseThatABentSheetAllows) {
  const PointsX3 points = Patch();
  const Rigid3 pose = LookAt({1, -3, 5}, {0, 0, 0});
  const std::vector<FeatureMatch> matches = PlaneMatches(points, pose);
  const std::vector<int> kept =
      ConsistentMatches(points, matches, kCamera, pose.translation.norm());
  int wrong = 0;
  for (const int i : kept) wrong += i % 5 == 0;
  EXPECT_GT(kept.size(), 300u);  // of 320
  EXPECT_LT(wrong, 8);           // of 80
}

TEST(SmoothMatches, RemovesThoseThatMoveUnlikeTheirNeighbours) {
  const PointsX3 points = Patch();
  const Rigid3 pose = LookAt({1, -3, 5}, {0, 0, 0});
  const std::vector<FeatureMatch> matches = PlaneMatches(points, pose);
  std::vector<Eigen::Vector2d> shown;  // the mesh is 10 pixels beside
  for (int i = 0; i < points.rows(); ++i)
    shown.push_back(kCamera.Project(pose * points.row(i).transpose()) + Eigen::Vector2d(10, 0));
  int wrong = 0;
  const std::vector<int> kept = SmoothMatches(points, matches, shown);
  for (const int i : kept) wrong += i % 5 == 0;
  EXPECT_EQ(kept.size() - wrong, 320u);
  EXPECT_LE(wrong, 1);
}

TEST(PlacePicture, FindsTheCameraAmongOutliers) {
  const PointsX3 points = Patch();
  const Rigid3 pose = LookAt({1, -3, 5}, {0, 0, 0});
  const PicturePose found = PlacePicture(kCamera, points, PlaneMatches(points, pose), 6, 12);
  ASSERT_TRUE(found.found);
  EXPECT_LT(found.camera_from_world.rotation.angularDistance(pose.rotation), 1e-3);
  EXPECT_LT((found.camera_from_world.Inverse().translation - pose.Inverse().translation).norm(),
            5e-3);
  EXPECT_GE(found.inliers.size(), 320u);
}

TEST(PlacePicture, FindsNothingInNoise) {
  const PointsX3 points = Patch();
  std::vector<FeatureMatch> matches = PlaneMatches(points, LookAt({1, -3, 5}, {0, 0, 0}));
  std::mt19937 random(3);
  for (FeatureMatch& match : matches) match.pixel = Eigen::Vector2d(random() % 800, random() % 800);
  EXPECT_FALSE(PlacePicture(kCamera, points, matches, 6, 12).found);
}

}  // namespace keypose::fit::bending_parts_test
