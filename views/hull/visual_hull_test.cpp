#include "views/hull/visual_hull.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "views/hull/testing/ball_ring.h"

namespace keypose::visual_hull_test {

VisualHullOptions Exact(int resolution) {
  VisualHullOptions options;
  options.resolution = resolution;
  options.outside_votes = 1;
  options.mask_margin_px = 0;
  return options;
}

TEST(VisualHull, SliceOfARingIsTheCircumscribedPolygon) {
  // n views of a circle give a regular n-gon around it (n even): area ratio (n / pi) tan(pi / n).
  for (const int n : {4, 6, 8}) {
    const VisualHull hull = CarveVisualHull(BallRing(n), Exact(160));
    const int z = static_cast<int>(std::floor(-hull.origin.z() / hull.cell));
    double area = 0;
    for (int y = 0; y < hull.size.y(); ++y)
      for (int x = 0; x < hull.size.x(); ++x) area += hull.Inside(x, y, z) * hull.cell * hull.cell;
    // The masks' border is known to half a pixel of 1/75.
    EXPECT_NEAR(area / M_PI, n / M_PI * std::tan(M_PI / n), 0.03) << n << " views";
  }
}

TEST(VisualHull, HoldsTheObjectAndItsNormalsPointOut) {
  const VisualHull hull = CarveVisualHull(BallRing(12, 6, 20), VisualHullOptions{});
  for (int i = 0; i < 200; ++i) {
    const double t = i * 0.7, z = -0.97 + i * 0.0097;
    const Eigen::Vector3d x(std::sqrt(1 - z * z) * std::cos(t), std::sqrt(1 - z * z) * std::sin(t),
                            z);
    EXPECT_TRUE(hull.Contains(x * 0.97)) << x.transpose();
  }
  EXPECT_FALSE(hull.Contains(Eigen::Vector3d(1.4, 0, 0)));
  const PointCloud surface = HullSurface(hull);
  int outward = 0;
  for (int i = 0; i < surface.points.rows(); ++i)
    outward += surface.normals.row(i).dot(surface.points.row(i)) > 0;
  EXPECT_GT(outward, 0.99 * static_cast<double>(surface.points.rows()));
}

TEST(VisualHull, OneBadMaskDoesNotCutTheObject) {
  std::vector<PreparedView> views = BallRing(12, 6, 20);
  for (PreparedView::Level& level : views[3].levels)  // half of the ball is missing
    for (int y = 0; y < level.grey.height / 2; ++y)
      for (int x = 0; x < level.grey.width; ++x) *level.grey.at(x, y) &= 0xFFFE;
  VisualHullOptions options;
  options.outside_votes = 2;
  const double tolerant = CarveVisualHull(views, options).Volume();
  options.outside_votes = 1;
  const double strict = CarveVisualHull(views, options).Volume();
  EXPECT_GT(tolerant, 4 * M_PI / 3);
  EXPECT_LT(strict, 0.8 * tolerant);
}

TEST(VisualHull, MasksWithoutCommonSpaceThrow) {
  std::vector<PreparedView> views = BallRing(6, 6);
  for (std::size_t i = 0; i < views.size();
       ++i)  // every camera sees the object in another direction
    views[i].camera_from_world.translation.x() += 40 * (i % 2 ? 1 : -1);
  VisualHullOptions options;
  options.outside_votes = 1;
  EXPECT_THROW(CarveVisualHull(views, options), InputError);
  EXPECT_THROW(CarveVisualHull({views[0]}, options), InputError);
}

TEST(VisualHull, SameBitsForAnyThreadCount) {
  const std::vector<PreparedView> views = BallRing(9, 6, 25);
  SetThreadCount(1);
  const VisualHull one = CarveVisualHull(views, Exact(96));
  SetThreadCount(3);
  const VisualHull three = CarveVisualHull(views, Exact(96));
  SetThreadCount(0);
  EXPECT_EQ(one.inside, three.inside);
  EXPECT_EQ(one.origin, three.origin);
}

}  // namespace keypose::visual_hull_test
