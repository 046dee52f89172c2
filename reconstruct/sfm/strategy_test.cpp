#include "reconstruct/sfm/strategy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "reconstruct/sfm/testing/result_with.h"
#include "reconstruct/testing/reported_stage.h"

namespace keypose::reconstruct::strategy_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

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
