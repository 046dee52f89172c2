// `keypose track` as a user runs it: a generated performance, bad input, and a real shot.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <regex>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "tests/run_program.h"

namespace keypose::tests::track_program_test {

namespace fs = std::filesystem;

/// One performance for all tests: 24 frames, an arm missing from all masks for a third of a second.
class TrackProgram : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TestingFolder;
    const RunResult made =
        RunProgram({"keypose-synth", "performance", "--output", "film", "--frames", "36", "--size",
                    "360", "--noise", "0.7", "--seed", "7", "--masks-only", "--hide-arm-from", "22",
                    "--hide-arm-to", "28"},
                   folder_->path());
    ASSERT_EQ(made.exit_code, 0) << made.output;
  }
  static void TearDownTestSuite() { delete folder_, folder_ = nullptr; }

  static fs::path Film() { return folder_->path() / "film"; }
  /// A copy of the film with its first frames only.
  static fs::path Copy(const std::string& name, int frames) {
    const fs::path to = folder_->path() / name;
    for (int c = 1; c <= 8; ++c) {
      const fs::path camera = fs::path("shot/masks") / ("cam" + std::to_string(c));
      fs::create_directories(to / camera);
      for (int f = 0; f < frames; ++f) {
        char number[16];
        std::snprintf(number, sizeof number, "%03d.png", f);
        fs::copy_file(Film() / camera / number, to / camera / number);
      }
    }
    fs::copy_file(Film() / "calibration.yml", to / "calibration.yml");
    return to;
  }
  static RunResult Track(const fs::path& film, const std::vector<std::string>& more = {}) {
    std::vector<std::string> command{"keypose-track",
                                     "--video",
                                     (film / "shot").string(),
                                     "--calibration",
                                     (film / "calibration.yml").string(),
                                     "--frames",
                                     (film / "frames").string(),
                                     "--motion",
                                     (film / "motion.bvh").string(),
                                     "--report",
                                     (film / "report.json").string()};
    command.insert(command.end(), more.begin(), more.end());
    return RunProgram(command, folder_->path(), {}, 800);
  }
  static nlohmann::json Report(const fs::path& film) {
    return nlohmann::json::parse(ReadFile(film / "report.json"));
  }
  /// Rewrites the calibration with camera `which` (-1: all) at `factor` times its translation.
  static void ScaleCameras(const fs::path& film, int which, double factor, bool with_unit) {
    std::vector<View> views = ReadRigCalibration(film / "calibration.yml").views;
    for (int c = 0; c < 8; ++c)
      if (which < 0 || c == which) views[c].camera_from_world.translation *= factor;
    std::string text = OpenCvYaml(views);
    if (!with_unit) text.erase(text.find("unit: m\n"), 8);
    WriteFile(film / "calibration.yml", text);
  }

  static TestingFolder* folder_;
};
TestingFolder* TrackProgram::folder_ = nullptr;

TEST_F(TrackProgram, FollowsAGeneratedPerformanceAndFindsAnArmThatWasHidden) {
  const RunResult run = Track(Film(), {"--actor_frames", "4"});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const RunResult scored = RunProgram({"keypose-synth", "score-motion", "--performance", "film",
                                       "--frames", "film/frames", "--motion", "film/motion.bvh"},
                                      folder_->path());
  ASSERT_EQ(scored.exit_code, 0) << scored.output;
  const nlohmann::json score = nlohmann::json::parse(scored.output);
  EXPECT_GT(score["iou_held_out"], 0.93);
  const std::vector<double> worst = score["frame_worst_mm"];
  double sum = 0;
  for (int f = 0; f < 22; ++f) sum += worst[f] / 22;
  // A pixel is about 10 mm here.
  EXPECT_LT(sum, 60) << scored.output;
  // The hidden arm cannot be known while it is hidden; five frames later it must be.
  for (int f = 33; f < 36; ++f) EXPECT_LT(worst[f], 90) << "frame " << f;
}

TEST_F(TrackProgram, WritesTheFolderThatInterpolateWrites) {
  const fs::path film = Copy("three", 3);
  const RunResult run = Track(film);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  for (const char* file :
       {"frame_0000.ply", "frame_0002.ply", "distortion.json", "angles.csv", "actor.json"})
    EXPECT_TRUE(fs::exists(film / "frames" / file)) << file;
  EXPECT_FALSE(fs::exists(film / "frames" / "frame_0003.ply"));
  const Mesh first = ReadMesh(film / "frames/frame_0000.ply"),
             last = ReadMesh(film / "frames/frame_0002.ply");
  EXPECT_EQ(first.faces, last.faces);
  const std::string csv = ReadFile(film / "frames/angles.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_NE(csv.find("left_shoulder_twist_variance"), std::string::npos);
  // With the actor of this run, nothing is fitted to the body again.
  fs::copy_file(film / "frames/actor.json", film / "actor.json");
  const RunResult again = Track(film, {"--actor", (film / "actor.json").string()});
  ASSERT_EQ(again.exit_code, 0) << again.output;
  EXPECT_EQ(ReadFile(film / "frames/actor.json"), ReadFile(film / "actor.json"));
}

TEST_F(TrackProgram, TremblingIsTakenOutUnlessItIsAskedToStay) {
  const fs::path film = Copy("calm", 16);
  RunResult run = Track(film, {"--actor_frames", "1"});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const nlohmann::json calm = Report(film)["measurements"];
  // The actor stands, and then begins to move: nearly all of it is noise.
  EXPECT_LT(calm["second_difference_ratio"], 0.5);
  const std::string motion = ReadFile(film / "motion.bvh");
  run = Track(film, {"--actor_frames", "1", "--calm", "0", "--overwrite"});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const nlohmann::json fits = Report(film)["measurements"];
  EXPECT_FALSE(fits.contains("second_difference_ratio"));
  EXPECT_NE(ReadFile(film / "motion.bvh"), motion);
  EXPECT_NEAR(calm["iou_mean"], fits["iou_mean"].get<double>(), 0.005);
}

TEST_F(TrackProgram, ACameraInMillimetresAmongMetresIsNamed) {
  const fs::path film = Copy("one_mm", 2);
  ScaleCameras(film, 2, 1000, true);
  const RunResult run = Track(film);
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.output.find("cam3"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("millimetres among metres"), std::string::npos) << run.output;
}

TEST_F(TrackProgram, ACalibrationAllInMillimetresGivesMillimetres) {
  const fs::path film = Copy("all_mm", 1);
  ScaleCameras(film, -1, 1000, false);
  const RunResult run = Track(film);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const Mesh mesh = ReadMesh(film / "frames/frame_0000.ply");
  const double height = mesh.points.col(2).maxCoeff() - mesh.points.col(2).minCoeff();
  EXPECT_GT(height, 1400);
  EXPECT_LT(height, 2000);
}

TEST_F(TrackProgram, OneShortFilmIsCutWithAWarningAndAVeryShortOneIsAnError) {
  const fs::path film = Copy("short", 4);
  fs::remove(film / "shot/masks/cam5/003.png");
  RunResult run = Track(film, {"--actor_frames", "1"});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_NE(run.output.find("camera cam5 has only 3 frames"), std::string::npos) << run.output;
  EXPECT_EQ(Report(film)["measurements"]["frames"], 3);
  for (const char* file : {"001.png", "002.png"}) fs::remove(film / "shot/masks/cam5" / file);
  run = Track(film);
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.output.find("cam5"), std::string::npos);
}

TEST_F(TrackProgram, CamerasThatDoNotOverlapAreAnError) {
  const fs::path film = Copy("apart", 1);
  std::vector<View> views = ReadRigCalibration(film / "calibration.yml").views;
  for (int c = 0; c < 8; ++c)
    views[c].camera_from_world.translation += Eigen::Vector3d(5.0 * c, 3.0 * (c % 3), 0);
  WriteFile(film / "calibration.yml", OpenCvYaml(views));
  const RunResult run = Track(film);
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.output.find("do not see one place"), std::string::npos) << run.output;
}

TEST_F(TrackProgram, FourCamerasAreTakenWithAWarning) {
  const fs::path film = Copy("four", 1);
  const RunResult run = Track(film, {"--cameras", "cam1, cam3, cam5, cam7"});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_NE(run.output.find("4 cameras do not see everything"), std::string::npos) << run.output;
  EXPECT_GT(Report(film)["measurements"]["iou_other_cameras"], 0.8);
}

TEST_F(TrackProgram, MasksOfOtherProgramsGiveTheSameFrames) {
  const auto film = [&](const std::string& name, int low, int high) {
    const fs::path copy = Copy(name, 1);
    for (int c = 1; c <= 8; ++c) {
      const fs::path file = copy / "shot/masks" / ("cam" + std::to_string(c)) / "000.png";
      Image8 mask = ReadImage(file, 1);
      for (std::uint8_t& value : mask.data)
        value = static_cast<std::uint8_t>(value > 127 ? high : low);
      WriteImage(file, mask);
    }
    const RunResult run = Track(copy, {"--cameras", "cam1, cam3, cam5, cam7"});
    EXPECT_EQ(run.exit_code, 0) << run.output;
    const bool said = run.output.find("the masks of camera cam3") != std::string::npos;
    EXPECT_EQ(said, high != 255) << run.output;
    return ReadFile(copy / "frames/frame_0000.ply");
  };
  const std::string plain = film("white", 0, 255);
  EXPECT_EQ(film("ones", 0, 1), plain);
  EXPECT_EQ(film("inverted", 255, 0), plain);
}

TEST_F(TrackProgram, ACalibrationWithYUpIsToldOf) {
  const fs::path film = Copy("y_up", 1);
  std::vector<View> views = ReadRigCalibration(film / "calibration.yml").views;
  const Eigen::Quaterniond z_from_y(
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
  for (View& view : views)
    view.camera_from_world.rotation = view.camera_from_world.rotation * z_from_y;
  WriteFile(film / "calibration.yml", OpenCvYaml(views));
  const RunResult run = Track(film, {"--cameras", "cam1, cam3, cam5, cam7"});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_NE(run.output.find("is not z of the calibration"), std::string::npos) << run.output;
  EXPECT_GT(Report(film)["measurements"]["iou_other_cameras"], 0.8);
}

TEST_F(TrackProgram, NamesThatDoNotMatchAreAnError) {
  const fs::path film = Copy("names", 1);
  fs::rename(film / "shot/masks/cam4", film / "shot/masks/left");
  const RunResult run = Track(film);
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.output.find("no camera left"), std::string::npos) << run.output;
}

TEST(TrackRealShot, EightOfTheDomesViewsExplainTheOtherTwelve) {
  const fs::path dome = DataFolder() / "motion/dome";
  if (!fs::exists(dome)) GTEST_SKIP() << dome << " is not here; set KEYPOSE_DATA";
  const TestingFolder folder;
  for (int c = 0; c < 20; ++c) {
    const std::string name = std::to_string(c);
    fs::create_directories(folder.path() / "shot/masks" / name);
    fs::copy_file(dome / "sil" / ("WD2_" + name + "_00020_segmented.png"),
                  folder.path() / "shot/masks" / name / "0.png");
  }
  const RunResult run =
      RunProgram({"keypose-track", "--video", "shot", "--calibration",
                  (dome / "calibParamsI.txt").string(), "--cameras", "0,2,5,7,10,12,15,17",
                  "--frames", "frames", "--motion", "motion.bvh", "--report", "report.json"},
                 folder.path(), {}, 600);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const auto report = nlohmann::json::parse(ReadFile(folder.path() / "report.json"));
  EXPECT_GT(report["measurements"]["iou_other_cameras"], 0.90);
  EXPECT_GT(report["measurements"]["iou_other_cameras_least"], 0.88);
}

}  // namespace keypose::tests::track_program_test
