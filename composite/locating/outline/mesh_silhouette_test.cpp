#include "composite/locating/outline/mesh_silhouette.h"

#include <gtest/gtest.h>

#include <cmath>

#include "composite/locating/testing/odd_body.h"
#include "core/pictures/fit_view.h"

namespace keypose::composite::mesh_silhouette_test {

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

}  // namespace keypose::composite::mesh_silhouette_test
