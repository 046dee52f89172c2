// Outlines of mattes and of meshes.
#include <gtest/gtest.h>

#include <cmath>

#include "composite/locating/outline/matte_outline.h"
#include "composite/locating/outline/mesh_silhouette.h"
#include "composite/locating/outline/shrunk.h"
#include "composite/locating/testing/odd_body.h"
#include "core/pictures/fit_view.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"

namespace keypose::composite::outline_test {

TEST(MatteOutline, OfADiskLiesOnItsCircle) {
  Image8 matte(200, 200, 1);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x)
      if (std::hypot(x + 0.5 - 100, y + 0.5 - 100) < 60) *matte.at(x, y) = 255;
  const MatteOutline outline(matte);
  // One point for each pixel of the circle's length, within the quarter that its direction allows.
  EXPECT_NEAR(SizeOf(outline.points()), 2 * 60 * 3.14159, 60);
  double mean = 0;
  for (const OutlinePoint& point : outline.points()) {
    const Eigen::Vector2d from = point.pixel - Eigen::Vector2d(100, 100);
    EXPECT_LT(std::abs(from.norm() - 60), 0.8);
    EXPECT_GT(from.normalized().dot(point.normal), 0.95);
    mean += (from.norm() - 60) / SizeOf(outline.points());
  }
  EXPECT_LT(std::abs(mean), 0.1);
}

TEST(FindSilhouette, OfABallIsItsCircleSeenFromOutside) {
  const Mesh ball = BallAt(0, 0, 0, 0.1);
  const Figure figure(ball.points, ball.faces);
  const Placement at{TestCamera(), LookAt({0.6, 0, 0}, {0, 0, 0})};
  const double radius = 900 * 0.1 / std::sqrt(0.6 * 0.6 - 0.1 * 0.1);
  const std::vector<SilhouettePoint> found = FindSilhouette(figure, at, 2);
  double length = 0;
  for (const SilhouettePoint& point : found) {
    const Eigen::Vector2d from = point.pixel - Eigen::Vector2d(320, 240);
    // The ball is a polyhedron, a little smaller.
    EXPECT_LT(std::abs(from.norm() - radius), 2.5);
    EXPECT_GT(from.normalized().dot(point.normal), 0.9);
    EXPECT_FALSE(point.inner);
    length += point.length_px;
  }
  EXPECT_NEAR(length, 2 * 3.14159 * radius, 0.03 * 2 * 3.14159 * radius);
}

TEST(FindSilhouette, InnerOutlinesAreThoseBeforeOtherParts) {
  const Mesh two = Joined(BallAt(0, 0, 0, 0.1), BallAt(0.3, 0, 0, 0.03));
  const Figure figure(two.points, two.faces);
  const Placement at{TestCamera(), LookAt({0.8, 0, 0}, {0, 0, 0})};
  int inner = 0;
  for (const SilhouettePoint& point : FindSilhouette(figure, at, 2, true)) {
    if (!point.inner) continue;
    ++inner;
    EXPECT_LT((point.pixel - Eigen::Vector2d(320, 240)).norm(), 60);
  }
  EXPECT_GT(inner, 20);
  for (const SilhouettePoint& point : FindSilhouette(figure, at, 2)) EXPECT_FALSE(point.inner);
}

TEST(Shrunk, KeepsTheMeanAndPlainPictures) {
  Image8 picture(7, 5, 1);
  double sum = 0;
  for (std::size_t i = 0; i < picture.data.size(); ++i)
    picture.data[i] = static_cast<std::uint8_t>(7 * i % 256), sum += picture.data[i];
  const Image8 one = Shrunk(picture, 1, 1);
  EXPECT_NEAR(one.data[0], sum / 35, 0.51);
  const Image8 plain = Shrunk(Image8(9, 9, 3, 77), 4, 3);
  for (const std::uint8_t value : plain.data) EXPECT_EQ(value, 77);
}

}  // namespace keypose::composite::outline_test
