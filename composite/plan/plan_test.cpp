#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

#include "composite/plan/camera_path.h"
#include "composite/plan/film_plan.h"
#include "composite/plan/placement.h"
#include "core/pictures/render.h"
#include "core/values/errors.h"

namespace keypose::composite::plan_test {

using ::testing::HasSubstr;

FilmedShot ShotWith(const std::vector<std::pair<int, std::string>>& frames, double fps = 12) {
  FilmedShot shot;
  shot.fps = fps;
  for (const auto& [number, pose] : frames) {
    ShotFrame frame;
    frame.frame = number, frame.pose = pose;
    shot.frames.push_back(frame);
  }
  return shot;
}

std::string KindsOf(const FilmPlan& plan) {
  std::string kinds;
  for (const PlannedPicture& picture : plan.pictures)
    kinds += "FBH"[static_cast<int>(picture.kind)];
  return kinds;
}

std::string FaultOf(const std::function<void()>& run) {
  try {
    run();
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(PlanFilm, TwelveBecomeTwentyFour) {
  const FilmPlan plan =
      PlanFilm(ShotWith({{0, "rest"}, {2, "wave"}}), {0, 1, 2}, {24, 5, {0, 4}, {}});
  EXPECT_EQ(KindsOf(plan), "FBFBF");
  EXPECT_EQ(plan.pictures[3].animation, 3);
  EXPECT_EQ(plan.pictures[4].filmed, 2);
  EXPECT_EQ(plan.filmed, 3);
  EXPECT_EQ(plan.between, 2);
}

TEST(PlanFilm, RatesOfTelevisionAreAsTyped) {
  const double ntsc = 24000.0 / 1001;
  for (const auto& [film, animation] :
       {std::pair{ntsc / 2, 23.976}, {11.988, ntsc}, {14.985, 29.97}})
    EXPECT_EQ(
        PlanFilm(ShotWith({{0, "rest"}, {2, "wave"}}, film), {0, 1, 2}, {animation, 5, {0, 4}, {}})
            .per_frame,
        2)
        << film;
  EXPECT_THAT(FaultOf([&] {
                PlanFilm(ShotWith({{0, "rest"}}), {0}, {23.976, 5, {0, 4}, {}});
              }),
              HasSubstr("must be a multiple"))
      << "a film of 12 would run away from it";
}

TEST(PlanFilm, GapsInTheFilmAreFilledAndEndsStand) {
  // The character enters at frame 1; frame 3 was not filmed; frame 5 comes after the last key.
  const FilmPlan plan =
      PlanFilm(ShotWith({{1, "rest"}, {4, "wave"}}), {0, 1, 2, 4, 5}, {24, 7, {0, 6}, {}});
  EXPECT_EQ(KindsOf(plan), "FHFBFBBBFHF");
  EXPECT_EQ(plan.start, 2);
  EXPECT_EQ(plan.first_frame, 1);
  EXPECT_EQ(plan.pictures[1].filmed, 0);
  EXPECT_EQ(plan.pictures[6].animation, 4);
  EXPECT_EQ(plan.held, 2);
}

TEST(PlanFilm, WithoutFilmEveryFrameIsRendered) {
  const FilmPlan plan = PlanFilm(ShotWith({{3, "rest"}}), {}, {12, 4, {}, {}});
  EXPECT_EQ(KindsOf(plan), "BBBB");
  EXPECT_EQ(plan.pictures[0].animation, 0);
}

TEST(PlanFilm, WithoutFilmACameraIsEnough) {
  const FilmPlan plan = PlanFilm(ShotWith({{2, ""}, {3, ""}}), {}, {24, 3, {0, 2}, {}});
  EXPECT_EQ(KindsOf(plan), "BBB");
  EXPECT_EQ(plan.pictures[0].animation, 0);
  EXPECT_EQ(plan.first_frame, 2);
}

TEST(PlanFilm, WhatDoesNotFitIsRefused) {
  const FilmedShot shot = ShotWith({{0, "rest"}, {2, "wave"}});
  EXPECT_THAT(FaultOf([&] { PlanFilm(shot, {0, 1, 2}, {25, 5, {}, {}}); }), HasSubstr("multiple"));
  EXPECT_THAT(FaultOf([&] {
                PlanFilm(shot, {0, 1, 2}, {24, 5, {0, 3}, {}});
              }),
              HasSubstr("at the animation's frames 0, 4, but the animation has its keys at 0, 3"));
  EXPECT_THAT(FaultOf([&] {
                PlanFilm(ShotWith({{0, ""}}), {0}, {24, 5, {}, {}});
              }),
              HasSubstr("no frame of the shot shows a key pose"));
}

/// A body, and an arm of a third of the vertices that swings about the body's corner.
PointsX3 BodyWithArm(double swing_rad) {
  PointsX3 points(90, 3);
  for (int i = 0; i < 60; ++i)
    points.row(i) << std::sin(1.0 * i), std::cos(1.7 * i), 0.5 + 0.5 * std::sin(2.3 * i);
  const Eigen::AngleAxisd swing(swing_rad, Eigen::Vector3d::UnitY());
  for (int i = 60; i < 90; ++i) {
    const Eigen::Vector3d x(0.05 * (i - 60), 0.02 * std::sin(i), 0.02 * std::cos(i));
    points.row(i) = (Eigen::Vector3d(1, 0, 0.5) + swing * x).transpose();
  }
  return points;
}

TEST(CommonMotion, ALimbDoesNotPullTheBody) {
  const Similarity3 moved{
      1, Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {0.2, -0.1, 0}};
  const PointsX3 a = BodyWithArm(0), b = Transformed(moved, BodyWithArm(1.2));
  const CommonMotion motion = FindCommonMotion(a, b);
  EXPECT_LT((motion.b_from_a.translation - moved.translation).norm(), 1e-3);
  EXPECT_LT(motion.weights.tail(20).maxCoeff(), 0.05);
  EXPECT_GT(motion.weights.head(60).minCoeff(), 0.5);
}

TEST(PlacementBetween, WhatStandsStillStandsStill) {
  // The shapes come in coordinates of their own, turned and scaled, as reconstructions do.
  const PointsX3 a = BodyWithArm(0), b = BodyWithArm(1.2), middle = BodyWithArm(0.6);
  const Similarity3 odd{
      0.5,
      Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix(),
      {3, 2, 1}};
  const PointsX3 placed = PlacementBetween(a, b).Place(Transformed(odd, middle), 2, 0.5);
  EXPECT_LT((placed - middle).rowwise().norm().maxCoeff(), 2e-3);
}

TEST(PlacementBetween, EndsAreTheLocatedPlaces) {
  const Similarity3 moved{
      1, Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {0.2, -0.1, 0}};
  const PointsX3 a = BodyWithArm(0), b = Transformed(moved, BodyWithArm(1.2));
  const PlacementBetween between(a, b);
  EXPECT_LT((between.Place(BodyWithArm(0), 1, 0) - a).rowwise().norm().maxCoeff(), 1e-9);
  EXPECT_LT((between.Place(BodyWithArm(1.2), 1, 1) - b).rowwise().norm().maxCoeff(), 1e-9);
}

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

}  // namespace keypose::composite::plan_test
