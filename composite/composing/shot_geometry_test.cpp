#include "composite/composing/shot_geometry.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::composite::shot_geometry_test {

/// A ball on the table that rolls from x = 0 to x = 1 in four frames, in a mesh's own units.
std::vector<Mesh> RollingBall() {
  std::vector<Mesh> frames;
  for (int i = 0; i < 5; ++i) {
    Mesh ball = MakeIcosphere(2);
    ball.points.col(2).array() += 1.2;  // its lowest point is at 0.2
    ball.points.col(0).array() += 0.25 * i;
    frames.push_back(ball);
  }
  return frames;
}

FilmedShot ShotOfTwo() {
  FilmedShot shot;
  shot.camera = {100, 80, 90, 90, 50, 40};
  for (const int number : {0, 2}) {
    ShotFrame frame;
    frame.frame = number, frame.pose = number ? "there" : "here";
    frame.world_from_character = {0.5, Eigen::Matrix3d::Identity(), {0, 0, 3}};
    shot.frames.push_back(frame);
  }
  return shot;
}

TEST(ShotGeometry, LocatedFramesAreWhereTheyWereFound) {
  const std::vector<Mesh> frames = RollingBall();
  const FilmedShot shot = ShotOfTwo();
  const AnimationTimes times{24, 5, {0, 4}, {0, 0.1, 0.2, 0.5, 1}};
  const FilmPlan plan = PlanFilm(shot, {0, 1, 2}, times);
  const ShotGeometry geometry(shot, plan, frames, times);
  ASSERT_EQ(geometry.anchors().size(), 2u);
  for (const int f : {0, 4})
    EXPECT_EQ(geometry.Points(f),
              Transformed(shot.frames[0].world_from_character, frames[f].points));
  // The whole ball moves as one: its way is the share of the time on the timeline.
  EXPECT_NEAR(geometry.At(2).share, 0.2, 1e-12);
  const PointsX3 second = geometry.Points(2);
  EXPECT_NEAR(second.col(0).mean(), 0.5 * 0.2, 1e-6);
  EXPECT_NEAR(geometry.Points(2.5).col(0).mean(),
              0.5 * (second.col(0).mean() + geometry.Points(3).col(0).mean()), 1e-9);
  EXPECT_EQ(geometry.Points(-3), geometry.Points(0)) << "clamped";
  const Ground table = geometry.Table();
  EXPECT_NEAR(table.origin.z(), 3 + 0.5 * 0.2, 1e-9);
  EXPECT_NEAR(table.up.z(), 1, 1e-12);
}

TEST(ShotGeometry, ACameraAloneMayBeFoundLateInItsFilm) {
  const std::vector<Mesh> frames = RollingBall();
  FilmedShot shot = ShotOfTwo();
  for (ShotFrame& frame : shot.frames) frame.frame += 7, frame.pose.clear();
  const AnimationTimes times{24, 5, {}, {}};
  const ShotGeometry geometry(shot, PlanFilm(shot, {}, times), frames, times);
  ASSERT_EQ(geometry.anchors().size(), 2u);
  EXPECT_EQ(geometry.anchors()[0].animation, 0);
  EXPECT_EQ(geometry.anchors()[1].animation, 4);
}

TEST(ShotGeometry, ShiftsGoStraightFromFrameToFrame) {
  const std::vector<Mesh> frames = RollingBall();
  const FilmedShot shot = ShotOfTwo();
  const AnimationTimes times{24, 5, {0, 4}, {0, 0.1, 0.2, 0.5, 1}};
  ShotGeometry geometry(shot, PlanFilm(shot, {0, 1, 2}, times), frames, times);
  std::vector<PointsX3> before;
  for (int f = 0; f < 5; ++f) before.push_back(geometry.Points(f));
  const PointsX3 one = PointsX3::Constant(before[0].rows(), 3, 1);
  geometry.SetShifts({{2, one}, {4, 3 * one}});
  for (const auto& [frame, shift] : {std::pair{0, 1.0}, {2, 1.0}, {3, 1.75}, {4, 3.0}})
    EXPECT_LT((geometry.Points(frame) - before[frame] - shift * one).cwiseAbs().maxCoeff(), 1e-9)
        << frame << ": by the timeline's time";
}

TEST(ShotGeometry, WhatCannotBePlacedIsRefused) {
  const std::vector<Mesh> frames = RollingBall();
  const AnimationTimes times{24, 5, {}, {}};
  FilmedShot shot = ShotOfTwo();
  shot.still = false;
  shot.frames.pop_back();
  const FilmPlan plan = PlanFilm(shot, {0, 1, 2}, times);
  EXPECT_THROW(ShotGeometry(shot, plan, frames, times), InputError) << "a way of one place";
}

TEST(ShotGeometry, AMovingCameraGoesFromLocatedFrameToLocatedFrame) {
  const std::vector<Mesh> frames = RollingBall();
  FilmedShot shot = ShotOfTwo();
  shot.still = false;
  shot.frames[1].camera_from_world.translation.x() = -0.4;
  const AnimationTimes times{24, 5, {0, 4}, {0, 0.1, 0.2, 0.5, 1}};
  const ShotGeometry geometry(shot, PlanFilm(shot, {0, 1, 2}, times), frames, times);
  EXPECT_FALSE(geometry.still());
  for (const auto& [frame, x] : {std::pair{-1.0, 0.0}, {0.0, 0.0}, {2.0, 0.2}, {4.0, 0.4}})
    EXPECT_NEAR(geometry.ViewAt(frame).Center().x(), x, 1e-12) << "by the film's clock";
  shot.between = {{0.5, {Eigen::Quaterniond::Identity(), {-0.35, 0, 0}}}};
  const ShotGeometry eased(shot, PlanFilm(shot, {0, 1, 2}, times), frames, times);
  EXPECT_NEAR(eased.ViewAt(1).Center().x(), 0.35, 1e-12) << "a plate was there";
  EXPECT_NEAR(eased.ViewAt(4).Center().x(), 0.4, 1e-12);
}

}  // namespace keypose::composite::shot_geometry_test
