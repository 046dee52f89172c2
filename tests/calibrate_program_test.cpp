// `keypose calibrate` as a user runs it, on rendered pictures of a board.
#include <gtest/gtest.h>

#include <filesystem>

#include "core/io/colmap_io.h"
#include "core/io/rig_calibration.h"
#include "core/io/testing_folder.h"
#include "tests/run_program.h"

namespace keypose::tests {
namespace {

namespace fs = std::filesystem;

TEST(CalibrateProgram, LensOfRenderedPicturesComesOutAndAPoorlyCoveredPictureIsSaid) {
  const TestingFolder folder;
  const RunResult made =
      RunProgram({"keypose-synth", "photos", "--output", "room", "--poses", "rest", "--views", "12",
                  "--width", "800", "--charuco", "--elevations", "25,50"},
                 folder.path());
  ASSERT_EQ(made.exit_code, 0) << made.output;
  fs::create_directories(folder.path() / "shot");
  fs::rename(folder.path() / "room/photos/rest", folder.path() / "shot/cam1");
  const RunResult run = RunProgram(
      {"keypose-calibrate", "--video", "shot", "--calibration", "rig.yml", "--every", "1"},
      folder.path());
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_NE(run.output.find("12 boards"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("its lens is a guess elsewhere"), std::string::npos) << run.output;
  const Scene truth = ReadColmapModel(folder.path() / "room/truth/rest/cameras");
  const RigCalibration rig = ReadRigCalibration(folder.path() / "rig.yml");
  ASSERT_EQ(rig.views.size(), 1u);
  EXPECT_EQ(rig.metres_per_unit, 1);
  // corners are found to a tenth of a pixel, over a third of the picture
  EXPECT_NEAR(rig.views[0].camera.fx / truth.views[0].camera.fx, 1, 0.005);
}

TEST(CalibrateProgram, PicturesWithoutABoardAreAnError) {
  const TestingFolder folder;
  const RunResult made = RunProgram({"keypose-synth", "photos", "--output", "room", "--poses",
                                     "rest", "--views", "6", "--width", "300"},
                                    folder.path());
  ASSERT_EQ(made.exit_code, 0) << made.output;
  fs::create_directories(folder.path() / "shot");
  fs::rename(folder.path() / "room/photos/rest", folder.path() / "shot/cam1");
  const RunResult run = RunProgram(
      {"keypose-calibrate", "--video", "shot", "--calibration", "rig.yml"}, folder.path());
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.output.find("cam1 saw the board in only 0 frames"), std::string::npos)
      << run.output;
}

}  // namespace
}  // namespace keypose::tests
