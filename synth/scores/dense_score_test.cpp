#include "synth/scores/dense_score.h"

#include <gtest/gtest.h>

#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "synth/scores/testing/ring_of_views.h"
#include "synth/worlds/world.h"

namespace keypose::synth::dense_score_test {

using Eigen::Vector3d;

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

}  // namespace keypose::synth::dense_score_test
