#include "synth/commands/score_command.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "synth/photographs/testing/synth_files.h"

namespace keypose::synth::score_command_test {

namespace fs = std::filesystem;

TEST_F(SynthFiles, TruthScoresZeroAgainstItself) {
  ScoreCommand command{folder_ / "truth/bent",
                       folder_ / "truth/bent/cameras",
                       folder_ / "truth/bent/surface.ply",
                       {},
                       {},
                       {},
                       {},
                       {},
                       {}};
  const std::string json = RunScore(command);
  EXPECT_NE(json.find("\"placed\": 6"), std::string::npos);
  EXPECT_NE(json.find("\"closed\": true"), std::string::npos);
}

}  // namespace keypose::synth::score_command_test
