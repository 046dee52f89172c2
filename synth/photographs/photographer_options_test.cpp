#include "synth/photographs/photographer_options.h"

#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "synth/photographs/photographer.h"
#include "synth/photographs/testing/small_photographs.h"

namespace keypose::synth::photographer_options_test {

TEST(Photographer, BadOptionsThrowUsageError) {
  const auto refuse = [](auto change) {
    PhotographerOptions options = Small();
    change(options);
    EXPECT_THROW(Photographer(Creature(), Creature().PoseNamed("rest"), options), UsageError);
  };
  refuse([](PhotographerOptions& o) { o.elevations_deg.clear(); });
  refuse([](PhotographerOptions& o) { o.elevations_deg = {89}; });
  refuse([](PhotographerOptions& o) { o.views = 1; });
  refuse([](PhotographerOptions& o) { o.width = 3; });
  refuse([](PhotographerOptions& o) { o.background = "beach"; });
  refuse([](PhotographerOptions& o) { o.board.charuco = true, o.board.marker_m = 0.05; });
}

}  // namespace keypose::synth::photographer_options_test
