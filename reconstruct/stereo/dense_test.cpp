#include "reconstruct/stereo/dense.h"

#include <gtest/gtest.h>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "reconstruct/testing/rendered_ring.h"

namespace keypose::reconstruct::dense_test {

using testing::Accuracy;
using testing::Measure;
using testing::Prepared;
using testing::RenderedScene;
using testing::RenderRing;

TEST(ReconstructDense, TexturedBallIsAccurateAndComplete) {
  const RenderedScene scene = RenderRing({.views = 9, .size = 150, .k1 = -0.05});
  const DenseResult result = ReconstructDense(Prepared(scene), scene.scene, {});
  const Accuracy accuracy = Measure(scene, result.cloud, result.stereo_points);
  EXPECT_LT(accuracy.footprints_90, 1.0);
  EXPECT_LT(accuracy.outliers, 0.002);
  EXPECT_GT(accuracy.completeness, 0.97);
  EXPECT_LT(accuracy.normal_deg_mean, 8);
  EXPECT_GT(result.stereo_points, 5000);
  EXPECT_TRUE(result.views_without_sources.empty());
  ASSERT_EQ(result.completeness.size(), 18u);
  for (const double share : result.completeness) EXPECT_GT(share, 0.5);
  for (int i = 0; i < result.stereo_points; ++i) {
    ASSERT_GT(result.cloud.confidence[i], 0.0f);
    ASSERT_LE(result.cloud.confidence[i], 1.0f);
  }
}

// Depths of flat windows on a ball are biased inwards. The ball of the scene is lumpy, and convex
// nearly everywhere.
TEST(ReconstructDense, NarrowWindowsAndTheCorrectionForCurvatureBringPointsNearerToACurvedSurface) {
  const RenderedScene scene = RenderRing({.views = 9, .size = 150});
  DenseOptions plain;
  plain.narrow_texture = 1000, plain.window_variance = 0;
  const std::vector<PreparedView> views = Prepared(scene);
  const DenseResult before = ReconstructDense(views, scene.scene, plain),
                    after = ReconstructDense(views, scene.scene, {});
  const Accuracy wide = Measure(scene, before.cloud, before.stereo_points),
                 narrow = Measure(scene, after.cloud, after.stereo_points);
  EXPECT_LT(narrow.footprints_90, 0.85 * wide.footprints_90) << wide.footprints_90;
  EXPECT_LE(narrow.outliers, wide.outliers + 1e-3);
  EXPECT_GT(narrow.completeness, wide.completeness - 0.005);
}

TEST(ReconstructDense, NoisyWeakTextureIsStillMatchedByWideWindows) {
  const RenderedScene scene = RenderRing({.views = 9, .size = 150, .contrast = 20, .noise = 4});
  DenseOptions wide, narrow;
  wide.narrow_texture = 1000, narrow.narrow_texture = 0;
  const std::vector<PreparedView> views = Prepared(scene);
  auto measured = [&](const DenseOptions& options) {
    const DenseResult result = ReconstructDense(views, scene.scene, options);
    return Measure(scene, result.cloud, result.stereo_points);
  };
  const Accuracy adapted = measured({}), all_wide = measured(wide), all_narrow = measured(narrow);
  EXPECT_GT(adapted.completeness, all_narrow.completeness + 0.02)
      << "narrow windows see too little";
  EXPECT_GT(adapted.completeness, all_wide.completeness - 0.005);
  EXPECT_LT(adapted.footprints_90, 1.02 * all_wide.footprints_90);
  EXPECT_LT(adapted.outliers, 0.002);
}

TEST(ReconstructDense, BallWithoutTextureGivesTheHullAndNoRandomDepths) {
  const RenderedScene scene = RenderRing({.views = 8, .size = 110, .contrast = 0});
  const DenseResult result = ReconstructDense(Prepared(scene), scene.scene, {});
  EXPECT_LT(result.stereo_points, 30);
  const int count = static_cast<int>(result.cloud.points.rows());
  ASSERT_GT(count, 3000);
  for (int i = result.stereo_points + result.gap_points; i < count - result.frontier_points; ++i)
    ASSERT_LE(result.cloud.confidence[i], 0.1f);
  const Accuracy accuracy = Measure(scene, result.cloud, count);
  EXPECT_LT(accuracy.footprints_90, 6)
      << "the hull of 16 views is near the ball except in its dent";
  EXPECT_GT(accuracy.completeness, 0.6);
}

int HullPoints(const DenseResult& result) {
  return static_cast<int>(result.cloud.points.rows()) - result.stereo_points - result.gap_points -
         result.frontier_points;
}

TEST(ReconstructDense, PointsWithoutDepthsAreAddedOnlyWhereAsked) {
  const RenderedScene scene = RenderRing({.views = 9, .size = 150, .contrast = 20, .noise = 4});
  const std::vector<PreparedView> views = Prepared(scene);
  const DenseResult all = ReconstructDense(views, scene.scene, {});
  EXPECT_GT(HullPoints(all), 0);
  EXPECT_GT(all.gap_points, 0);
  DenseOptions options;
  options.hull_fill = false;
  EXPECT_EQ(HullPoints(ReconstructDense(views, scene.scene, options)), 0);
  options = {};
  options.gap_fill = false;
  EXPECT_EQ(ReconstructDense(views, scene.scene, options).gap_points, 0);
}

TEST(ReconstructDense, PointsFartherOutsideOfTheMasksThanAllowedAreDropped) {
  const RenderedScene scene = RenderRing({.views = 9, .size = 150});
  const std::vector<PreparedView> views = Prepared(scene);
  DenseOptions wide;
  wide.outline_px = 100;
  EXPECT_EQ(ReconstructDense(views, scene.scene, wide).outside_points, 0);
  DenseOptions none;
  none.outline_px = 0;
  EXPECT_GT(ReconstructDense(views, scene.scene, none).outside_points, 0);
}

TEST(ReconstructDense, SameBitsForAnyThreadCount) {
  const RenderedScene scene = RenderRing({.views = 8, .size = 72});
  SetThreadCount(1);
  const DenseResult one = ReconstructDense(Prepared(scene), scene.scene, {});
  SetThreadCount(2);
  const DenseResult two = ReconstructDense(Prepared(scene), scene.scene, {});
  SetThreadCount(0);
  ASSERT_GT(one.stereo_points, 500);
  ASSERT_EQ(one.cloud.points.rows(), two.cloud.points.rows());
  EXPECT_TRUE((one.cloud.points.array() == two.cloud.points.array()).all());
  EXPECT_TRUE((one.cloud.normals.array() == two.cloud.normals.array()).all());
  EXPECT_TRUE((one.cloud.confidence.array() == two.cloud.confidence.array()).all());
  EXPECT_EQ(one.evaluations, two.evaluations);
}

TEST(ReconstructDense, TooFewOrLonelyViewsThrowWithTheirNames) {
  RenderedScene scene = RenderRing(
      {.views = 3, .size = 60});  // 120 degrees apart; the two rings are 30 degrees apart
  std::vector<PreparedView> views = Prepared(scene);
  try {
    ReconstructDense({views[0], views[1], views[2]}, scene.scene, {});
    FAIL() << "views 120 degrees apart share nothing";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("view_100.png"), std::string::npos) << e.what();
  }
  views.resize(2);
  EXPECT_THROW(ReconstructDense(views, scene.scene, {}), InputError);
}

}  // namespace keypose::reconstruct::dense_test
