// Shares of shapes that cameras on one side, or all round, do not see.
#include "cleanup/support/unseen.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/testing/shots.h"
#include "core/values/angles.h"
#include "core/values/errors.h"

namespace keypose::cleanup::unseen_test {

using Eigen::Vector3d;

/// `count` of twelve cameras in a ring.
std::vector<View> Ring(const Vector3d& middle, double elevation_deg, int count) {
  std::vector<View> views = MasksFromRings(MakeBox(1, 1, 1), middle, {elevation_deg}, 12, 64).views;
  views.resize(static_cast<std::size_t>(count));
  return views;
}

// From 4 radii away, lines of sight are 10 degrees above a sphere at the angle t from the camera's
// direction where the triangle of the sphere's middle, the place and the camera has 100 degrees at
// the place: t = 80 degrees - asin(sin(100 degrees) / 4).
TEST(MeasureUnseen, OfASphereBeforeOneCameraTheCapIsSeen) {
  const double t = 80 * kPi / 180 - std::asin(std::sin(100 * kPi / 180) / 4);
  const double unseen = (1 + std::cos(t)) / 2;
  const double sole =
      0.05;  // the cap below a tenth of the radius: as its height is of the diameter
  const UnseenSurface measured = MeasureUnseen(MakeIcosphere(5), Ring({0, 0, 0}, 0, 1));
  // A face is seen or not: borders that are off by half a face of 0.04, all along, make 0.009.
  EXPECT_NEAR(measured.share, unseen - sole, 0.006);
  EXPECT_NEAR(measured.sole_share, sole, 0.003);
}

TEST(MeasureUnseen, ABoxOnTheGroundSeenAllRoundHasASoleAndNoMore) {
  const UnseenSurface measured = MeasureUnseen(MakeBox(1, 1, 2), Ring({0.5, 0.5, 1}, 25, 12));
  EXPECT_NEAR(measured.share, 0, 1e-12);
  EXPECT_NEAR(measured.sole_share, 0.1, 1e-12);  // 1 of 1 + 1 + 4 times 2
}

TEST(MeasureUnseen, WhatTheMeshHidesAndWhatThePictureCutsIsNotSeen) {
  // A plate before a box hides the side that both have to the camera.
  Mesh both = MakeBox(1, 1, 1);
  Mesh plate = MakeBox(0.1, 3, 3);
  plate.points.rowwise() += Eigen::RowVector3d(1.5, -1, -1);
  both.faces.conservativeResize(24, 3), both.points.conservativeResize(16, 3);
  both.points.bottomRows(8) = plate.points;
  both.faces.bottomRows(12) = plate.faces.array() + 8;
  const View front = Ring({0.5, 0.5, 0.5}, 0, 1)[0];  // on the x axis
  const double alone = 6, of_plate = 2 * 9 + 4 * 0.3;
  const UnseenSurface hidden = MeasureUnseen(both, {front});
  EXPECT_NEAR(hidden.share + hidden.sole_share, 1 - 9 / (alone + of_plate), 1e-12);
  View aside = front;
  aside.camera.cx += 10 * aside.camera.width;
  const UnseenSurface cut = MeasureUnseen(MakeBox(1, 1, 1), {aside});
  EXPECT_NEAR(cut.share + cut.sole_share, 1, 1e-12);
}

TEST(MeasureUnseen, WithoutFacesThrows) { EXPECT_THROW(MeasureUnseen({}, {}), InputError); }

TEST(CleanupProgram, SaysHowMuchPhotographsOfOneSideDoNotSee) {
  const TestingFolder own;
  const std::string at = own.path().string();
  Mesh ball = MakeIcosphere(4);
  ball.points.col(2).array() += 1;
  // Four cameras of twelve, over a quarter of the way round.
  MaskShot shot = MasksOf(ball, Ring({0, 0, 1}, 20, 4));
  WriteShot(own.path(), shot);
  WriteMesh(own.path() / "ball.ply", ball);
  const std::string command = BinFolder() + "/keypose-cleanup --surface " + at +
                              "/ball.ply --images " + at + "/images --model " + at +
                              "/model --clean " + at + "/clean.ply --report " + at +
                              "/report.json > " + at + "/log 2>&1";
  ASSERT_EQ(WEXITSTATUS(std::system(command.c_str())), 0) << ReadFile(own.path() / "log");
  const auto measured = nlohmann::json::parse(ReadFile(own.path() / "report.json"))["measurements"];
  const UnseenSurface truth = MeasureUnseen(ball, shot.views);
  EXPECT_GT(truth.share, 0.3);
  EXPECT_NEAR(measured["unseen_share"], truth.share, 0.01);
}

}  // namespace keypose::cleanup::unseen_test
