#include "views/hull/visual_hull.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/values/errors.h"
#include "views/hull/depth_bounds.h"
#include "views/hull/view_selection.h"

namespace keypose::visual_hull_test {

// Masks of the unit ball from a ring of cameras, so far away that they are nearly orthographic.
std::vector<PreparedView> BallRing(int count, double distance = 50, double elevation_deg = 0,
                                   int levels = 2) {
  std::vector<PreparedView> views;
  for (int i = 0; i < count; ++i) {
    const double azimuth = 2 * M_PI * i / count, elevation = elevation_deg * M_PI / 180;
    View view;
    view.name = "v" + std::to_string(i);
    view.camera.width = view.camera.height = 200;
    view.camera.fx = view.camera.fy = 75 * distance;
    view.camera.cx = view.camera.cy = 100;
    view.camera_from_world = LookAt(
        distance * Eigen::Vector3d(std::cos(azimuth) * std::cos(elevation),
                                   std::sin(azimuth) * std::cos(elevation), std::sin(elevation)),
        Eigen::Vector3d::Zero());
    const double radius = view.camera.fx / std::sqrt(distance * distance - 1);
    Image8 mask(200, 200, 1);
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 200; ++x)
        if (std::hypot(x + 0.5 - 100, y + 0.5 - 100) <= radius) *mask.at(x, y) = 255;
    views.push_back(PrepareView(view, i, Image8(200, 200, 3, 128), mask, 1.0, levels));
  }
  return views;
}

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

TEST(ViewSelection, RingNeighboursComeFirstWhateverTheOrderOfFiles) {
  std::vector<PreparedView> views = BallRing(30, 6, 20);
  std::swap(views[4], views[17]);
  const VisualHull hull = CarveVisualHull(views, VisualHullOptions{});
  std::vector<DepthBounds> bounds;
  for (const PreparedView& view : views) bounds.push_back(HullDepthBounds(hull, view));
  const std::vector<std::vector<int>> sources = SelectSourceViews(views, bounds, Scene{}, 6);
  for (std::size_t i = 0; i < views.size(); ++i) {
    ASSERT_EQ(sources[i].size(), 6u);
    for (const int s : sources[i]) {
      const double cosine = views[i].Center().normalized().dot(views[s].Center().normalized());
      EXPECT_LT(std::acos(cosine) * 180 / M_PI, 37) << "12 degrees a step: three on each side";
    }
  }
}

}  // namespace keypose::visual_hull_test
