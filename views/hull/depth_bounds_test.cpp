#include "views/hull/depth_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "views/hull/testing/ball_ring.h"
#include "views/hull/visual_hull.h"

namespace keypose::depth_bounds_test {

TEST(DepthBounds, BracketTheBall) {
  const std::vector<PreparedView> views = BallRing(16, 6, 25);
  const VisualHull hull = CarveVisualHull(views, VisualHullOptions{});
  const DepthBounds bounds = HullDepthBounds(hull, views[0]);
  const Pinhole& camera = views[0].camera(bounds.shift);
  int checked = 0;
  double gap = 0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d ray = camera.Ray(x, y),
                            center = views[0].camera_from_world * Eigen::Vector3d(0, 0, 0);
      const double b = ray.dot(center) / ray.squaredNorm(),
                   disc = b * b - (center.squaredNorm() - 1) / ray.squaredNorm();
      if (disc < 0.01) continue;
      const double depth = b - std::sqrt(disc);
      EXPECT_GE(*bounds.nearest.at(x, y), 1 / depth);
      EXPECT_LE(*bounds.farthest.at(x, y), 1 / depth);
      gap += depth - 1 / *bounds.nearest.at(x, y);
      ++checked;
    }
  ASSERT_GT(checked, 1000);
  EXPECT_LT(gap / checked, 0.15) << "the hull of 16 views is close to the ball";
}

TEST(DepthBounds, AThreadThatRunsDiagonallyHasTheSlopeAlongIt) {
  // One voxel and one coarse pixel thick, so that a window says nothing across the thread.
  std::vector<PreparedView> views = BallRing(1);
  for (PreparedView::Level& level : views[0].levels)
    std::fill(level.grey.data.begin(), level.grey.data.end(), std::uint16_t{0xFFFF});
  VisualHull hull;
  hull.cell = 2.0 / 75, hull.size.setConstant(40), hull.origin.setConstant(-20 * hull.cell);
  hull.inside.assign(40 * 40 * 40, 0);
  for (std::size_t i = 0; i < 40; ++i) hull.inside[(i * 40 + i) * 40 + i] = 1;
  const DepthBounds bounds = HullDepthBounds(hull, views[0]);
  int pixels = 0;
  for (int y = 0; y < bounds.slope.height; ++y)
    for (int x = 0; x < bounds.slope.width; ++x) {
      const float gx = bounds.slope.at(x, y)[0], gy = bounds.slope.at(x, y)[1];
      ASSERT_TRUE(std::isfinite(gx) && std::isfinite(gy)) << x << " " << y;
      if (gx == 0 && gy == 0) continue;
      ++pixels;
      // Each voxel along the thread is a cell farther or nearer: 1 / z changes by cell / z^2.
      // Rays enter voxels at corners or at faces, hence the tolerance.
      EXPECT_NEAR(std::abs(gx) + std::abs(gy), hull.cell / 2500, 0.25 * hull.cell / 2500);
    }
  EXPECT_GE(pixels, 30);
}

}  // namespace keypose::depth_bounds_test
