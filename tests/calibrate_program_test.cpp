// `keypose calibrate` as a user runs it, on rendered pictures of a board.
#include <gtest/gtest.h>

#include <filesystem>

#include "core/errors.h"
#include "core/io/colmap_io.h"
#include "core/io/files.h"
#include "core/io/known_points_io.h"
#include "core/io/rig_calibration.h"
#include "core/io/testing_folder.h"
#include "tests/run_program.h"

namespace keypose::tests {
namespace {

namespace fs = std::filesystem;

/// Twelve photographs of a figure on the printed board, rendered once; room/truth has the cameras.
const fs::path& Room() {
  static const TestingFolder folder;
  static const RunResult made =
      RunProgram({"keypose-synth", "photos", "--output", "room", "--poses", "rest", "--views", "12",
                  "--width", "800", "--charuco", "--elevations", "25,50"},
                 folder.path());
  static const fs::path room = folder.path() / "room";
  EXPECT_EQ(made.exit_code, 0) << made.output;
  return room;
}

TEST(CalibrateProgram, LensOfRenderedPicturesComesOutAndAPoorlyCoveredPictureIsSaid) {
  const TestingFolder folder;
  fs::create_directories(folder.path() / "shot");
  fs::copy(Room() / "photos/rest", folder.path() / "shot/cam1");
  const RunResult run = RunProgram(
      {"keypose-calibrate", "--video", "shot", "--calibration", "rig.yml", "--every", "1"},
      folder.path());
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_NE(run.output.find("12 boards"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("its lens is a guess elsewhere"), std::string::npos) << run.output;
  const Scene truth = ReadColmapModel(Room() / "truth/rest/cameras");
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
  EXPECT_NE(run.output.find("none showed markers or a checkerboard"), std::string::npos)
      << run.output;
}

/// Points of known place about the figure, clicked where the truth's first view sees them.
std::string ClickedPoints(const View& view, int wrong) {
  KnownPoints known;
  ClickedPicture clicked{"still", "", view.camera.width, view.camera.height, {}};
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d place(i & 1 ? 0.06 : -0.06, i & 2 ? 0.05 : -0.05, i & 4 ? 0.08 : 0);
    known.points.push_back({"corner " + std::to_string(i), place});
    Eigen::Vector2d pixel = view.Project(place);
    if (i == wrong) pixel += Eigen::Vector2d(40, -25);
    clicked.clicks.push_back({i, pixel});
  }
  known.cameras = {clicked};
  return KnownPointsText(known);
}

TEST(CalibrateProgram, BoardPicturesGiveTheLensAndClickedPointsThePlace) {
  const TestingFolder folder;
  fs::create_directories(folder.path() / "boards");
  fs::copy(Room() / "photos/rest", folder.path() / "boards/still");
  const View truth = ReadColmapModel(Room() / "truth/rest/cameras").views[0];
  WriteFile(folder.path() / "points.json", ClickedPoints(truth, 5));
  const RunResult run = RunProgram({"keypose-calibrate", "--lenses", "boards", "--points",
                                    "points.json", "--calibration", "rig.yml"},
                                   folder.path());
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_NE(run.output.find("the click of 'corner 5' is 4"), std::string::npos) << run.output;
  EXPECT_EQ(run.output.find("the click of 'corner 4'"), std::string::npos) << run.output;
  const View placed = ReadRigCalibration(folder.path() / "rig.yml").views.at(0);
  // the lens is known to half a percent
  const double distance = truth.Center().norm();
  EXPECT_LT((placed.Center() - truth.Center()).norm(), 0.01 * distance);

  // the lens alone, which is no calibration of a rig, but serves as --lenses the next time
  const RunResult lens = RunProgram(
      {"keypose-calibrate", "--lenses", "boards", "--calibration", "lens.yml"}, folder.path());
  ASSERT_EQ(lens.exit_code, 0) << lens.output;
  EXPECT_THROW(ReadRigCalibration(folder.path() / "lens.yml"), InputError);
  const RunResult again = RunProgram({"keypose-calibrate", "--lenses", "lens.yml", "--points",
                                      "points.json", "--calibration", "again.yml"},
                                     folder.path());
  ASSERT_EQ(again.exit_code, 0) << again.output;
  EXPECT_EQ(ReadFile(folder.path() / "again.yml"), ReadFile(folder.path() / "rig.yml"));
}

TEST(CalibrateProgram, NothingToCalibrateFromIsAUsageError) {
  const TestingFolder folder;
  const RunResult run =
      RunProgram({"keypose-calibrate", "--calibration", "rig.yml"}, folder.path());
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.output.find("--points"), std::string::npos) << run.output;
}

}  // namespace
}  // namespace keypose::tests
