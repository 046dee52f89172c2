// Cameras from clicked points, against the cameras that saw them.
#include "capture/rig/point_placement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/pictures/fit_view.h"
#include "core/values/errors.h"

namespace keypose::capture::point_placement_test {

using ::testing::HasSubstr;

double Wobble(int i, double size) {
  const double x = std::sin(12.9898 * i) * 43758.5453;
  return 3.46 * size * (x - std::floor(x) - 0.5);
}

/// A treadmill's corners and four points of a door beside it.
std::vector<KnownPoint> Treadmill(bool door) {
  std::vector<KnownPoint> points{{"far left", {-2, 0.3, 0}},   {"far rail", {-2, 0, 0.05}},
                                 {"far right", {-2, -0.3, 0}}, {"near left", {0, 0.3, 0}},
                                 {"near rail", {0, 0, 0.05}},  {"near right", {0, -0.3, 0}},
                                 {"far middle", {-2, 0, 0}},   {"near middle", {0, 0, 0}}};
  if (door)
    for (const double z : {0.0, 2.0})
      for (const double x : {-1.5, -0.6})
        points.push_back({"door " + std::to_string(points.size()), {x, 1.6, z}});
  return points;
}

View Truth() {
  View view;
  view.name = "cam1";
  view.camera = {1080, 1920, 1680, 1682, 533, 951, -0.05, 0.1, 4e-4, -3e-4};
  view.camera_from_world = LookAt({1.6, -2.4, 1.9}, {-0.9, 0.3, 0.4});
  return view;
}

ClickedPicture Clicked(const View& view, const std::vector<KnownPoint>& points, double error_px) {
  ClickedPicture camera{view.name, "", view.camera.width, view.camera.height, {}};
  for (int p = 0; p < static_cast<int>(points.size()); ++p)
    camera.clicks.push_back(
        {p, view.Project(points[p].place) +
                Eigen::Vector2d(Wobble(2 * p + 1, error_px), Wobble(2 * p + 2, error_px))});
  return camera;
}

TEST(PlaceCamera, ExactClicksGiveThePlaceBack) {
  const auto points = Treadmill(false);
  const PlacedCamera placed = PlaceCamera(Clicked(Truth(), points, 0), Truth().camera, points);
  EXPECT_LT((placed.view.Center() - Truth().Center()).norm(), 1e-5);
  EXPECT_LT(placed.rms_px, 1e-3);
  for (const ClickError& click : placed.clicks) EXPECT_FALSE(click.wrong);
}

TEST(PlaceCamera, ClicksOfAPixelTellTheirOwnError) {
  const auto points = Treadmill(false);
  double sum = 0, told = 0;
  constexpr int kTries = 20;
  for (int i = 0; i < kTries; ++i) {
    ClickedPicture camera = Clicked(Truth(), points, 0);
    for (PointClick& click : camera.clicks)
      click.pixel += Eigen::Vector2d(Wobble(100 * i + 2 * click.point, 1),
                                     Wobble(100 * i + 2 * click.point + 1, 1));
    const PlacedCamera placed = PlaceCamera(camera, Truth().camera, points);
    sum += (placed.view.Center() - Truth().Center()).squaredNorm();
    told += placed.place_error_m * placed.place_error_m;
    EXPECT_LT(placed.rms_px, 2.5);
  }
  const double error = std::sqrt(sum / kTries);
  EXPECT_LT(error, 0.03);
  // twenty tries tell a standard deviation to a quarter
  EXPECT_NEAR(std::sqrt(told / kTries) / error, 1, 0.5);
}

TEST(PlaceCamera, WrongAndExchangedClicksAreNamed) {
  const auto points = Treadmill(false);
  ClickedPicture camera = Clicked(Truth(), points, 0.7);
  camera.clicks[2].pixel += Eigen::Vector2d(60, -35);
  PlacedCamera placed = PlaceCamera(camera, Truth().camera, points);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(placed.clicks[i].wrong, i == 2) << i;
  EXPECT_NEAR(placed.clicks[2].px, std::hypot(60, 35), 6);
  EXPECT_LT((placed.clicks[2].expected - Truth().Project(points[2].place)).norm(), 6);
  EXPECT_LT((placed.view.Center() - Truth().Center()).norm(), 0.06);

  camera = Clicked(Truth(), points, 0.7);
  std::swap(camera.clicks[3].pixel, camera.clicks[5].pixel);
  placed = PlaceCamera(camera, Truth().camera, points);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(placed.clicks[i].wrong, i == 3 || i == 5) << i;
}

TEST(PlaceCamera, WithoutALensTheFocalLengthComesFromThePoints) {
  const auto points = Treadmill(true);
  View plain = Truth();
  plain.camera = {1080, 1920, 1500, 1500, 540, 960, 0, 0, 0, 0};
  ClickedPicture camera = Clicked(plain, points, 0.5);
  const PlacedCamera placed = PlaceCamera(camera, {}, points);
  EXPECT_NEAR(placed.view.camera.fx / 1500, 1, 0.01);
  EXPECT_LT((placed.view.Center() - plain.Center()).norm(), 0.03);
  EXPECT_GT(placed.focal_error, 0);
  EXPECT_LT(placed.focal_error, 0.01);
}

TEST(PlaceCamera, TooFewClicksAndPointsOnALineAreErrors) {
  const auto points = Treadmill(false);
  ClickedPicture camera = Clicked(Truth(), points, 0);
  camera.clicks.resize(3);
  EXPECT_THROW(PlaceCamera(camera, Truth().camera, points), InputError);
  camera = Clicked(Truth(), points, 0);
  camera.clicks.resize(5);
  try {
    PlaceCamera(camera, {}, points);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("camera cam1 has 5 clicks; 6 are needed without board"));
  }
  std::vector<KnownPoint> line;
  for (int i = 0; i < 6; ++i) line.push_back({"p" + std::to_string(i), {-0.4 * i, 0, 0}});
  try {
    PlaceCamera(Clicked(Truth(), line, 0), Truth().camera, line);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("lie on a line"));
  }
}

TEST(PlaceCamera, ClicksThatAgreeWithNoPlaceAreAnError) {
  const auto points = Treadmill(true);
  ClickedPicture camera = Clicked(Truth(), points, 0);
  for (PointClick& click : camera.clicks)
    click.pixel = {300 + 400 * std::abs(Wobble(click.point, 0.5)),
                   300 + 1200 * std::abs(Wobble(click.point + 50, 0.5))};
  EXPECT_THROW(PlaceCamera(camera, Truth().camera, points), InputError);
}

TEST(SeePoints, APointThatWasMeasuredWronglyIsSeenWhereItIs) {
  const auto points = Treadmill(true);
  auto told = points;
  told[9].place += Eigen::Vector3d(0, 0.05, 0.02);
  std::vector<ClickedPicture> cameras;
  std::vector<PlacedCamera> placed;
  for (const Eigen::Vector3d& eye : {Eigen::Vector3d(1.6, -2.4, 1.9), Eigen::Vector3d(-3, -2, 2)}) {
    View view = Truth();
    view.camera_from_world = LookAt(eye, {-0.9, 0.5, 0.7});
    cameras.push_back(Clicked(view, points, 0));
    PlacedCamera camera;
    camera.view = view;
    camera.clicks.resize(points.size());
    for (int p = 0; p < static_cast<int>(points.size()); ++p) camera.clicks[p].point = p;
    placed.push_back(camera);
  }
  for (const SeenPoint& seen : SeePoints(cameras, placed, told)) {
    EXPECT_EQ(seen.cameras, 2);
    EXPECT_NEAR(seen.apart_m, seen.point == 9 ? std::hypot(0.05, 0.02) : 0, 1e-6);
  }
}

}  // namespace keypose::capture::point_placement_test
