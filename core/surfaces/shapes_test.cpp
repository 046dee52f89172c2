#include "core/surfaces/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/values/angles.h"

namespace keypose::shapes_test {

TEST(MakeIcosphere, EachLevelSplitsFacesInFourAndComesNearerToTheSphere) {
  double missing = 4 * kPi / 3;
  for (int level = 0; level < 4; ++level) {
    const Mesh ball = MakeIcosphere(level);
    EXPECT_EQ(ball.face_count(), 20 << (2 * level));
    EXPECT_TRUE(CheckClosed(ball).closed());
    EXPECT_LT((ball.points.rowwise().norm().array() - 1).abs().maxCoeff(), 1e-14);
    const double now = 4 * kPi / 3 - SignedVolume(ball.points, ball.faces);
    EXPECT_GT(now, 0);
    EXPECT_LT(now, 0.5 * missing);
    missing = now;
  }
}

TEST(MakeBox, HasItsCornersVolumeAndTwelveFaces) {
  const Mesh box = MakeBox(1, 2, 3);
  EXPECT_EQ(box.face_count(), 12);
  EXPECT_TRUE(CheckClosed(box).closed());
  EXPECT_NEAR(SignedVolume(box.points, box.faces), 6, 1e-14);
  EXPECT_EQ(Eigen::RowVector3d(box.points.colwise().minCoeff()), Eigen::RowVector3d(0, 0, 0));
  EXPECT_EQ(Eigen::RowVector3d(box.points.colwise().maxCoeff()), Eigen::RowVector3d(1, 2, 3));
}

TEST(MakeCylinder, IsThePrismOfItsPolygon) {
  const Mesh tube = MakeCylinder(0.5, 2, 6, 3);
  EXPECT_TRUE(CheckClosed(tube).closed());
  EXPECT_EQ(tube.face_count(), 2 * 3 * 6 + 2 * 6);
  const double hexagon = 0.5 * 6 * 0.25 * std::sin(kPi / 3);
  EXPECT_NEAR(SignedVolume(tube.points, tube.faces), 2 * hexagon, 1e-12);
}

}  // namespace keypose::shapes_test
