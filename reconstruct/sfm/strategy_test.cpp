#include "reconstruct/sfm/strategy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "reconstruct/sfm/set_lenses.h"
#include "reconstruct/sfm/turntable_strategies.h"
#include "reconstruct/testing/reported_stage.h"

namespace keypose::reconstruct::strategy_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;

/// Of 16 photographs, all placed.
StrategyResult ResultWith(const std::string& method, double hull_overlap) {
  StrategyResult result{.method = method};
  result.evidence.images = result.evidence.placed = 16;
  result.evidence.outlines = true;
  result.evidence.hull_iou = hull_overlap;
  return result;
}

/// A photograph of a set, reduced from another size if that is given.
CapturedImage Photograph(int width, int height, double focal_px, int of_width = 0,
                         int of_height = 0) {
  CapturedImage image;
  image.width = width, image.height = height;
  image.photograph_width = of_width, image.photograph_height = of_height;
  image.focal_px = focal_px;
  return image;
}

TEST(LensesOf, EachSizeIsALensAlsoIfItWasMadeTheSameSize) {
  ImageSet set;
  for (int i = 0; i < 9; ++i)
    set.images.push_back(i % 3 == 0   ? Photograph(2000, 1500, 2400, 4000, 3000)
                         : i % 3 == 1 ? Photograph(2000, 1500, 0, 1500 * 2, 2000 * 2)
                                      : Photograph(2000, 1500, 0));
  const SetLenses lenses = LensesOf(set);
  ASSERT_EQ(lenses.cameras.size(), 2U);  // a portrait that was turned is of the same camera
  EXPECT_THAT(lenses.of_image, ElementsAre(0, 0, 1, 0, 0, 1, 0, 0, 1));
  EXPECT_EQ(lenses.cameras[0].fx, 2400);
  EXPECT_EQ(lenses.cameras[1].fx, 2400);  // the only focal length that is known
  EXPECT_TRUE(lenses.focal_known);
}

TEST(PlaceByTurntable, PhotographsOfTwoSizesAreNoRing) {
  ReportedStage stage;
  const ImageSet set;
  const EvidenceCheck check(set);
  Stopwatch watch;
  SfmOptions options;
  MatchedFeatures matched;
  matched.lenses.resize(2);
  matched.lenses[0].width = matched.lenses[0].height = 800;
  matched.lenses[1].width = matched.lenses[1].height = 480;
  matched.camera = matched.lenses[0];
  const StrategyContext context{stage, set, options, check, watch};
  const StrategyResult best = PlaceByTurntable(context, {}, matched, ResultWith("features", 0.5));
  EXPECT_EQ(best.method, "features");
  for (const char* method : {"ring", "silhouettes"}) {
    options.method = method;
    try {
      PlaceByTurntable(context, {}, matched, {});
      ADD_FAILURE() << method;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr(method), HasSubstr("800 x 800 and 480 x 480")));
    }
  }
}

TEST(Measurements, KeepTheirOrderAndTheLastValueOfAName) {
  Measurements measurements;
  measurements.Add("second_try", false);
  measurements.Add("error_px", 0.5);
  measurements.Add("second_try", true);
  ASSERT_EQ(measurements.values().size(), 2U);
  EXPECT_EQ(measurements.values()[0].first, "second_try");
  EXPECT_EQ(std::get<bool>(measurements.values()[0].second), true);
  EXPECT_EQ(std::get<double>(*measurements.Find("error_px")), 0.5);
  EXPECT_EQ(measurements.Find("error"), nullptr);
}

TEST(Measurements, ReachTheReportWithTheirKinds) {
  Measurements measurements;
  measurements.Add("is_ring", true);
  measurements.Add("points", 7);
  measurements.Add("error_px", 0.5);
  measurements.Add("layout", "18+18");
  measurements.AddJson("sizes", "[3,4]");
  measurements.Warn("look");
  ReportedStage stage;
  measurements.Report(stage);
  EXPECT_THAT(stage.values,
              ElementsAre(Pair("error_px", "0.500000"), Pair("is_ring", "true"),
                          Pair("layout", "18+18"), Pair("points", "7"), Pair("sizes", "[3,4]")));
  EXPECT_THAT(stage.warnings, ElementsAre("look"));
}

TEST(BetterOf, OnlyTheTakenResultLeavesNumbersInTheReport) {
  StrategyResult features = ResultWith("features", 0.56), ring = ResultWith("ring", 0.95);
  features.measurements.AddJson("model_sizes", "[16]");
  features.measurements.Warn("of features");
  ring.measurements.Add("ring_inliers", 400);
  for (const bool ring_last : {true, false}) {
    const StrategyResult best = ring_last ? BetterOf(features, ring) : BetterOf(ring, features);
    EXPECT_EQ(best.method, "ring");
    ReportedStage stage;
    best.measurements.Report(stage);
    EXPECT_THAT(stage.values, ElementsAre(Pair("ring_inliers", "400")));
    EXPECT_THAT(stage.warnings, IsEmpty());
  }
}

TEST(BetterOf, AResultWithoutCamerasIsNeverTaken) {
  StrategyResult nothing{.method = "silhouettes"};
  nothing.measurements.Add("silhouette_error_px", 9.0);
  EXPECT_EQ(BetterOf(ResultWith("features", 0.56), nothing).method, "features");
  EXPECT_TRUE(BetterOf(StrategyResult{}, nothing).measurements.values().empty());
}

TEST(FocalsToTry, OnlyTheKnownOneOrSevenFromTheLikeliest) {
  MatchedFeatures matched;
  matched.camera.width = 1000, matched.camera.height = 800;
  matched.camera.fx = matched.camera.fy = 1200;
  EXPECT_THAT(FocalsToTry(matched), ElementsAre(1200, 1450, 1750, 1000, 2100, 850, 2550));
  matched.focal_known = true;
  EXPECT_THAT(FocalsToTry(matched), ElementsAre(1200));
}

}  // namespace keypose::reconstruct::strategy_test
