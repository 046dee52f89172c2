#include "synth/scores/true_hull.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "synth/scores/dense_score.h"
#include "synth/scores/testing/ring_of_views.h"

namespace keypose::synth::true_hull_test {

using Eigen::Vector3d;

TEST(HullOfMasks, BallFromARingHasTheSagittaOfItsPolygon) {
  // Twelve cameras in the equatorial plane: there the hull of a ball is a regular polygon around
  // the circle.
  const std::vector<View> views = Around(12, 0, 600);
  std::vector<Image8> masks;
  for (const View& view : views) {
    Image8 mask(view.camera.width, view.camera.height, 1);
    // Outline of a ball at distance d: a circle of radius f r / sqrt(d^2 - r^2).
    const double radius = view.camera.fx * kRadius / std::sqrt(0.25 - kRadius * kRadius);
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x)
        *mask.at(x, y) = std::hypot(x + 0.5 - 300, y + 0.5 - 300) <= radius ? 255 : 0;
    masks.push_back(mask);
  }
  const Mesh hull =
      HullOfMasks(views, masks, Vector3d::Constant(-0.08), Vector3d::Constant(0.08), 0.002);
  EXPECT_TRUE(CheckClosed(hull).closed());
  double nearest = 1, farthest = 0;
  for (Eigen::Index i = 0; i < hull.points.rows(); ++i) {
    if (std::abs(hull.points(i, 2)) > 0.002) continue;
    const double r = hull.points.row(i).head<2>().norm();
    nearest = std::min(nearest, r), farthest = std::max(farthest, r);
  }
  // There are 24 tangent planes. The outermost corners are intersections of tangents of
  // neighbouring views, at r / cos(half their angle). For cameras at infinity this half angle
  // is 7.5 degrees. At half a metre the tangents of opposite views differ by 2 asin(r / d), so the
  // corners alternate.
  EXPECT_NEAR(nearest, kRadius, 0.0003);
  EXPECT_GT(farthest, kRadius / std::cos(7.5 * M_PI / 180) - 0.0002);
  EXPECT_LT(farthest, kRadius / std::cos(15 * M_PI / 180) + 0.0003);
  EXPECT_THROW(
      HullOfMasks(views, {masks[0]}, Vector3d::Constant(-0.08), Vector3d::Constant(0.08), 0.002),
      InputError);
}

TEST(CompareWithHull, CountsWhereTheSurfaceIsWorse) {
  const Mesh truth = Ball(kRadius), hull = Ball(1.04 * kRadius), mesh = Ball(1.01 * kRadius);
  const HullComparison better = CompareWithHull(truth, Around(12, 0), mesh, hull);
  EXPECT_NEAR(better.ratio(), 0.25, 0.02);
  EXPECT_EQ(better.worse_share, 0);
  const HullComparison worse = CompareWithHull(truth, Around(12, 0), hull, mesh);
  EXPECT_EQ(worse.worse_share, 1);
  EXPECT_NEAR(worse.worst_excess_footprints, 0.03 * kRadius / (0.45 / 600), 0.2);
}

}  // namespace keypose::synth::true_hull_test
