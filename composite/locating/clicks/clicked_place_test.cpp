// A place by pairs of pixel and vertex.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "composite/locating/clicks/clicked_place.h"
#include "composite/locating/testing/odd_body.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::composite::clicked_place_test {

using ::testing::HasSubstr;

TEST(PlaceByClicks, CubeCornersReprojectToAThousandthOfAPixel) {
  const PointsX3 corners = MakeBox(0.1, 0.1, 0.1).points;
  Placement truth = LookingFrom(40, 25);
  truth.camera.k1 = -0.1;
  std::vector<Click> clicks;
  for (const int v : {0, 1, 2, 5}) {
    SurfacePoint point;
    point.vertices.setConstant(v);
    clicks.push_back({"corner", truth.Project(corners.row(v)), point});
  }
  const Placement found = PlaceByClicks(truth.camera, corners, clicks, false);
  EXPECT_LT(ShiftBetween(found, truth, corners), 1e-3);
}

TEST(PlaceByClicks, SixClicksAlsoGiveTheFocalLength) {
  const PointsX3 corners = MakeBox(0.1, 0.15, 0.2).points;
  const Placement truth = LookingFrom(40, 25, 0.4);
  std::vector<Click> clicks;
  for (int v = 0; v < 8; ++v) {
    SurfacePoint point;
    point.vertices.setConstant(v);
    clicks.push_back({"corner", truth.Project(corners.row(v)), point});
  }
  Camera start = truth.camera;
  start.fx *= 1.3, start.fy *= 1.3;
  const Placement found = PlaceByClicks(start, corners, clicks, true);
  EXPECT_NEAR(found.camera.fx, truth.camera.fx, 0.01);
}

TEST(PlaceByClicks, NamesTheClickThatDoesNotAgree) {
  const PointsX3 corners = MakeBox(0.1, 0.15, 0.2).points;
  const Placement truth = LookingFrom(40, 25);
  std::vector<Click> clicks;
  for (int v = 0; v < 6; ++v) {
    SurfacePoint point;
    point.vertices.setConstant(v);
    clicks.push_back({"click " + std::to_string(v + 1), truth.Project(corners.row(v)), point});
  }
  clicks[3].pixel += Eigen::Vector2d(150, 90);
  try {
    PlaceByClicks(truth.camera, corners, clicks, false);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("click 4"));
  }
}

TEST(PlaceByClicks, ThreeClicksAndClicksOnALineAreRefused) {
  PointsX3 line(4, 3);
  line << 0, 0, 0, 0, 0, 0.1, 0, 0, 0.2, 0, 0, 0.3;
  std::vector<Click> clicks;
  for (int v = 0; v < 4; ++v) {
    SurfacePoint point;
    point.vertices.setConstant(v);
    clicks.push_back({"click", {100.0 + v, 200}, point});
  }
  EXPECT_THROW(PlaceByClicks(TestCamera(), line, clicks, false), InputError);
  clicks.pop_back();
  EXPECT_THROW(PlaceByClicks(TestCamera(), line, clicks, false), InputError);
}

}  // namespace keypose::composite::clicked_place_test
