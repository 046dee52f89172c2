#include "synth/scores/dense_score.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "synth/photographs/photographer.h"
#include "synth/scores/true_hull.h"
#include "synth/worlds/lying.h"
#include "synth/worlds/polygonize.h"
#include "synth/worlds/world.h"

namespace keypose::synth::dense_score_test {

using Eigen::Vector3d;

constexpr double kRadius = 0.05;

Mesh Ball(double radius, double spacing = 0.004) {
  return Polygonize([&](const Vector3d& x) { return x.norm() - radius; },
                    Vector3d::Constant(-1.2 * radius), Vector3d::Constant(1.2 * radius), spacing);
}

// Cameras on a sphere of 0.5 m around the origin.
std::vector<View> Around(int count, double elevation_deg, int size = 200) {
  std::vector<View> views;
  for (int k = 0; k < count; ++k) {
    const double a = 2 * M_PI * k / count, e = elevation_deg * M_PI / 180;
    View view;
    view.name = std::to_string(k);
    view.camera.width = view.camera.height = size;
    view.camera.fx = view.camera.fy = 3.0 * size;
    view.camera.cx = view.camera.cy = size / 2.0;
    view.camera_from_world =
        LookAt(0.5 * Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)),
               Vector3d::Zero());
    views.push_back(view);
  }
  return views;
}

TEST(ScorePoints, KnowsShiftsInFootprintsAndWhatIsMissing) {
  const Mesh ball = Ball(kRadius);
  const std::vector<View> views = Around(12, 0);
  const double footprint = PixelFootprint(views, views[0].Center() * ((0.5 - 0.3) / 0.5));
  EXPECT_NEAR(footprint, 0.3 / 600, 1e-9);
  // All points lie 1.5 footprints outside the surface, only on the upper half.
  PointsX3 points = SampleSurface(ball.points, ball.faces, 30000, 5).points;
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (points(i, 2) > 0) rows.push_back(i);
  const PointsX3 upper = points(rows, Eigen::all);
  PointsX3 outside = upper;
  for (Eigen::Index i = 0; i < upper.rows(); ++i)
    outside.row(i) *= 1 + 1.5 * PixelFootprint(views, upper.row(i)) / upper.row(i).norm();
  const PointsScore exact = ScorePoints(ball, views, upper, 0.002),
                    shifted = ScorePoints(ball, views, outside, 0.002);
  EXPECT_LT(exact.p99, 0.01);
  EXPECT_EQ(exact.within_one_footprint, 1);
  EXPECT_NEAR(exact.completeness, 0.52, 0.02);
  EXPECT_NEAR(shifted.median, 1.5, 0.02);
  EXPECT_EQ(shifted.within_one_footprint, 0);
  EXPECT_THROW(ScorePoints(ball, views, PointsX3(0, 3), 0.002), InputError);
}

TEST(ScorePoints, UnseenSurfaceDoesNotCountAgainstTheSeen) {
  const Mesh ball = Ball(kRadius);
  const std::vector<View> views = Around(12, 60);  // these do not see the lower cap
  const SurfaceSamples samples = SampleSurface(ball.points, ball.faces, 30000, 5);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < samples.points.rows(); ++i)
    if (samples.points(i, 2) > -0.5 * kRadius) rows.push_back(i);
  const PointsScore score = ScorePoints(ball, views, samples.points(rows, Eigen::all), 0.002);
  EXPECT_NEAR(score.completeness, 0.77, 0.02);
  EXPECT_GT(score.completeness_seen, 0.99);
}

World Printed() {
  WorldOptions options;
  options.spacing_m = 0.0018;
  options.prints_move = true;
  options.print_spacing_m = 0.0060;
  options.print_height_m = 0.0003;
  return MakeWorld(options);
}

TEST(ScoreDetail, IsOneForTheTruthNothingForTheSmoothAndHalfBetween) {
  const World world = Printed();
  EXPECT_TRUE(CheckClosed(world.rest).closed());
  EXPECT_NEAR((world.rest.points - world.smooth).rowwise().norm().maxCoeff(), 0.0003, 0.00003);
  const DetailScore whole = ScoreDetail(world.rest, world.smooth, world.rest);
  ASSERT_GT(whole.places, 1000);
  EXPECT_NEAR(whole.gain, 1, 0.02);
  EXPECT_GT(whole.correlation, 0.99);
  Mesh smooth = world.rest, half = world.rest;
  smooth.points = world.smooth;
  half.points = (world.rest.points + world.smooth) / 2;
  EXPECT_NEAR(ScoreDetail(world.rest, world.smooth, smooth).gain, 0, 0.02);
  EXPECT_NEAR(ScoreDetail(world.rest, world.smooth, half).gain, 0.5, 0.02);
  EXPECT_EQ(ScoreDetail(smooth, world.smooth, smooth).places, 0);
}

TEST(MakeWorld, PrintsThatMoveNeedAFineSurface) {
  WorldOptions options;
  options.prints_move = true;
  EXPECT_THROW(MakeWorld(options), InputError);
}

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

TEST(LayDown, IsARigidTurnOntoTheBack) {
  WorldOptions options;
  options.spacing_m = 0.006;
  const World world = MakeWorld(options);
  const Pose& bent = world.PoseNamed("bent");
  const PointsX3 standing = bent(world.rest.points);
  const Lying lying = LayDown(bent, standing);
  const PointsX3 points = lying.pose(world.rest.points);
  EXPECT_NEAR(points.col(2).minCoeff(), 0, 1e-12);
  EXPECT_NEAR(points.col(1).minCoeff() + points.col(1).maxCoeff(), 0, 1e-12);
  for (Eigen::Index i = 0; i < standing.rows(); i += 50)
    EXPECT_LT(
        (lying.table_from_character * Vector3d(standing.row(i)) - Vector3d(points.row(i))).norm(),
        1e-12);
  // The soles, which were on the table, now face forwards.
  Eigen::Index sole;
  standing.col(2).minCoeff(&sole);
  EXPECT_LT(points(sole, 1), points.col(1).minCoeff() + 0.002);
}

}  // namespace keypose::synth::dense_score_test
