// Shares of shapes that cameras on one side, or all round, do not see.
#include "cleanup/support/unseen.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cleanup/testing/camera_ring.h"
#include "core/surfaces/shapes.h"
#include "core/values/angles.h"
#include "core/values/errors.h"

namespace keypose::cleanup::unseen_test {

using Eigen::Vector3d;

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

}  // namespace keypose::cleanup::unseen_test
