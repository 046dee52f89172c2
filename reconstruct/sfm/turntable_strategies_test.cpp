#include "reconstruct/sfm/turntable_strategies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "reconstruct/sfm/strategy.h"
#include "reconstruct/sfm/testing/result_with.h"
#include "reconstruct/testing/reported_stage.h"

namespace keypose::reconstruct::turntable_strategies_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

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

}  // namespace keypose::reconstruct::turntable_strategies_test
