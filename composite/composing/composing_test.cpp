#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numeric>

#include "composite/composing/film_lessons.h"
#include "composite/composing/join.h"
#include "composite/composing/shot_geometry.h"
#include "composite/layer/linear_light.h"
#include "core/pictures/render.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::composite::composing_test {

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

TEST(Looks, TexturesAreMixedByTheirWeights) {
  Looks looks;
  looks.textures = {ImageF(2, 2, 3, 0.2f), ImageF(2, 2, 3, 0.6f)};
  EXPECT_FLOAT_EQ(looks.At(1).texture.data[3], 0.2f);
  looks.weights = {{1, 0}, {0.25, 0.75}};
  EXPECT_FLOAT_EQ(looks.At(0).texture.data[3], 0.2f);
  EXPECT_FLOAT_EQ(looks.At(1).texture.data[3], 0.5f);
}

/// A ball on a grey table before a camera that looks down on it, in a lamp from the left. It stands
/// beyond the picture's right border, so that its shadow is not seen, until the last frame.
class BallEntersLate : public ::testing::Test {
 protected:
  BallEntersLate() {
    for (int i = 0; i < 7; ++i) {
      Mesh ball = MakeIcosphere(2);
      ball.points *= 0.5;
      ball.points.col(2).array() += 0.5;
      ball.points.col(0).array() += i == 6 ? 0 : 3.2;
      ball.uvs = UvsX2::Constant(1, 2, 0.5);
      frames_.push_back(ball);
    }
    looks_.faces = frames_[0].faces, looks_.uvs = frames_[0].uvs;
    looks_.uv_faces = FacesX3::Zero(looks_.faces.rows(), 3);
    looks_.textures = {ImageF(1, 1, 3, 0.3f)};
    shot_.camera = {120, 90, 110, 110, 60, 45};
    for (int i = 0; i < 7; ++i) {
      ShotFrame frame;
      frame.frame = i, frame.pose = "here";
      frame.camera_from_world = LookAt({0, -2.5, 3.5}, {0, 0, 0});
      shot_.frames.push_back(frame);
    }
  }

  /// What a film in this light shows, without grain.
  ImageF Filmed(const ShotGeometry& geometry, int frame) const {
    const View view = geometry.ViewAt(frame);
    const PixelRays rays(view.camera);
    const Ground table = geometry.Table();
    const PointsX3 points = geometry.Points(frame);
    const RayScene scene(points, looks_.faces);
    const ImageF layer = RenderLayer(looks_.At(frame), points, scene, {}, view, rays, 2, &table),
                 kept = ShadowPicture(scene, table, lamp_, nullptr, view, rays);
    ImageF light(view.camera.width, view.camera.height, 3);
    for (std::size_t i = 0; i < light.data.size(); ++i)
      light.data[i] =
          layer.data[i / 3 * 4 + i % 3] + (1 - layer.data[i / 3 * 4 + 3]) * 0.4f * kept.data[i / 3];
    return LevelsOf(light);
  }

  std::vector<Mesh> frames_;
  Looks looks_;
  FilmedShot shot_;
  ShadowStrength lamp_{0.2, 0.5, {Eigen::Vector3d(-0.8, 0.2, 1).normalized(), 0.05}};
};

TEST_F(BallEntersLate, TheShadowIsLearntFromTheWholeShot) {
  std::vector<int> numbers(frames_.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  const AnimationTimes times{12, 7, {}, {}};
  const ShotGeometry geometry(shot_, PlanFilm(shot_, numbers, times), frames_, times);
  Film film;
  film.read = [&](int i) { return Filmed(geometry, i); };
  film.given_plate = LevelsOf(ImageF(120, 90, 3, 0.4f));
  for (int i = 0; i < 7; ++i) film.pictures.push_back({i, i, i, true, true});
  const FilmLessons lessons = LearnFromFilm(geometry, looks_, film, {}, nullptr);
  EXPECT_GT(lessons.shadow.explained, 0.8);
  EXPECT_NEAR(lessons.shadow.strength.lamp, 0.5, 0.1);
  EXPECT_GT(lessons.shadow.strength.light.direction.dot(lamp_.light.direction), 0.99);
}

/// A bright disk on a dark ground, with a soft edge.
Image8 Disk(double x0, int bright) {
  Image8 picture(120, 90, 3);
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x) {
      const double inside = std::clamp(25.5 - std::hypot(x + 0.5 - x0, y + 0.5 - 45), 0.0, 1.0);
      for (int c = 0; c < 3; ++c)
        picture.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(50 + inside * (bright - 50)));
    }
  return picture;
}

ImageF CoverageOfDisk() {
  ImageF coverage(120, 90, 1);
  for (int y = 0; y < 90; ++y)
    for (int x = 0; x < 120; ++x)
      *coverage.at(x, y) =
          static_cast<float>(std::clamp(25.5 - std::hypot(x + 0.5 - 60, y + 0.5 - 45), 0.0, 1.0));
  return coverage;
}

TEST(Join, EqualPicturesJoinPerfectly) {
  const JoinFigures figures = MeasureJoin(Disk(60, 200), Disk(60, 200), CoverageOfDisk());
  EXPECT_EQ(figures.psnr_db, 99);
  EXPECT_EQ(figures.edge_px, 0);
  EXPECT_EQ(figures.colour_levels, 0);
  EXPECT_EQ(figures.edge_share, 1);
  EXPECT_EQ(figures.box[0], 60 - 25 - 8);
  EXPECT_EQ(figures.box[3], 45 + 25 + 8);
}

TEST(Join, ADisksShiftIsFoundAlongItsNormals) {
  const JoinFigures figures = MeasureJoin(Disk(60, 200), Disk(61.2, 200), CoverageOfDisk());
  EXPECT_NEAR(figures.edge_px, 1.2 * 2 / M_PI, 0.08) << "the mean of |cosine| round the disk";
  EXPECT_LT(figures.psnr_db, 35);
}

TEST(Join, AColourIsADifferenceOfColour) {
  const JoinFigures figures = MeasureJoin(Disk(60, 206), Disk(60, 200), CoverageOfDisk());
  EXPECT_NEAR(figures.colour_levels, 6, 0.3);
  EXPECT_LT(figures.edge_px, 0.1);
}

TEST(Join, NothingCoveredIsNoJoin) {
  const JoinFigures figures = MeasureJoin(Disk(60, 200), Disk(60, 200), ImageF(120, 90, 1));
  EXPECT_EQ(figures.psnr_db, 0);
  EXPECT_EQ(figures.box[2], 0);
}

TEST(Join, SideBySideShowsFourTimesTheDifference) {
  const Image8 sheet = SideBySide(Image8(10, 5, 3, 100), Image8(10, 5, 3, 103));
  EXPECT_EQ(sheet.width, 3 * 10 + 2 * 4);
  EXPECT_EQ(sheet.at(0, 0)[0], 100);
  EXPECT_EQ(sheet.at(14, 0)[0], 103);
  EXPECT_EQ(sheet.at(28, 0)[0], 128 + 12);
}

}  // namespace keypose::composite::composing_test
