#include "synth/photographs/truth_files.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/values/errors.h"
#include "synth/photographs/testing/synth_files.h"

namespace keypose::synth::truth_files_test {

namespace fs = std::filesystem;

TEST_F(SynthFiles, TruthComesBackAsItWasRendered) {
  const World world = MakeWorld(command_.world);
  const Truth truth = ReadTruth(folder_ / "truth/bent");
  const Photographer photographer(world, world.PoseNamed("bent"), command_.photographer);
  EXPECT_EQ(truth.surface.points, photographer.surface().points);
  EXPECT_EQ(truth.surface.faces, world.rest.faces);
  ASSERT_EQ(truth.cameras.views.size(), 6u);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(truth.cameras.views[i].name, photographer.ViewAt(i).name);
    EXPECT_LT((truth.cameras.views[i].Center() - photographer.ViewAt(i).Center()).norm(), 1e-12);
    EXPECT_DOUBLE_EQ(truth.cameras.views[i].camera.k1, photographer.ViewAt(i).camera.k1);
  }
  ASSERT_EQ(truth.landmarks.size(), world.landmarks.size());
  EXPECT_EQ(truth.landmarks[3].vertex, world.landmarks[3].vertex);
  EXPECT_THROW(ReadTruth(folder_ / "photos"), Error);
}

}  // namespace keypose::synth::truth_files_test
