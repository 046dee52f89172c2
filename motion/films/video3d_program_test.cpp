// The program keypose-video3d, as a user starts it, and the export of what it writes.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/size_of.h"
#include "motion/testing/filmed_ball.h"
#include "views/film/mp4.h"

namespace keypose::motion::video3d_program_test {

namespace fs = std::filesystem;

constexpr int kFrames = 3;

class Video3d : public ::testing::Test, public TestingFolder {
 protected:
  /// Films the ball, once for all tests; each has a copy of its own.
  static void SetUpTestSuite() {
    filmed_ = std::make_unique<TestingFolder>();
    fs::create_directories(filmed_->path() / "frames");
    for (int f = 0; f < kFrames; ++f) {
      Mesh frame = world_.mesh;
      frame.points = world_.Points(f);
      WriteMesh(filmed_->path() / "frames" / FrameFileName(f), frame);
    }
    for (const View& view : world_.views)
      for (int f = 0; f < kFrames; ++f) WriteFilmed(view, f);
  }
  static void TearDownTestSuite() { filmed_.reset(); }
  Video3d() {
    fs::copy(filmed_->path(), folder_, fs::copy_options::recursive);
    WriteCalibration(world_.views);
  }

  static void WriteFilmed(const View& view, int f) {
    const std::string number = std::to_string(f) + ".png";
    const fs::path shot = filmed_->path() / "shot";
    fs::create_directories(shot / view.name);
    fs::create_directories(shot / "masks" / view.name);
    WriteImage(shot / view.name / number, world_.Picture(view, f));
    WriteImage(shot / "masks" / view.name / number, world_.Mask(view, f));
  }
  void WriteCalibration(const std::vector<View>& views) const {
    WriteFile(folder_ / "rig.yml", OpenCvYaml(views));
  }
  int Run(const std::string& program, const std::string& arguments) {
    const std::string command = "cd '" + folder_.string() + "' && '" + BinFolder() + "/keypose-" +
                                program + "' " + arguments + " > log.txt 2>&1";
    const int status = std::system(command.c_str());
    log_ = ReadFile(folder_ / "log.txt");
    return WEXITSTATUS(status);
  }
  int RunVideo3d(const std::string& more = "") {
    return Run("video3d",
               "--frames frames --video shot --calibration rig.yml --textures out --overwrite "
               "--texture_size 256 --report report.json " +
                   more);
  }
  bool Says(const std::string& words) const { return log_.find(words) != std::string::npos; }

  static inline const BallWorld world_{5, 96};
  static inline std::unique_ptr<TestingFolder> filmed_;
  std::string log_;
};

TEST_F(Video3d, WritesATextureAFrameAndAFilmThatExportTakes) {
  ASSERT_EQ(RunVideo3d("--film orbit.mp4 --view_width 96 --view_height 64 --picture seen.jpg"), 0)
      << log_;
  for (int f = 0; f < kFrames; ++f) {
    const Image8 texture =
        ReadImage(folder_ / "out" / ("frame_000" + std::to_string(f) + ".png"), 3);
    EXPECT_EQ(texture.width, 256);
  }
  EXPECT_GT(fs::file_size(folder_ / "orbit.mp4"), 1000u);
  EXPECT_TRUE(fs::exists(folder_ / "seen.jpg"));
  const auto report = nlohmann::json::parse(ReadFile(folder_ / "report.json"))["measurements"];
  EXPECT_EQ(report["frames"], kFrames);
  EXPECT_EQ(report["cameras"].size(), 5u);
  EXPECT_GT(report["own_fraction"].get<double>(), 0.6);

  ASSERT_EQ(Run("export",
                "--frames frames --textures out --animation animation --formats glb,obj,video "
                "--video_width 96 --video_height 64 --fps 12"),
            0)
      << log_;
  const std::string obj = ReadFile(folder_ / "animation/obj/frame_0002.obj");
  EXPECT_NE(obj.find("mtllib frame_0002.mtl"), std::string::npos);
  EXPECT_NE(ReadFile(folder_ / "animation/obj/frame_0002.mtl").find("../textures/frame_0002.png"),
            std::string::npos);
  for (int f = 0; f < kFrames; ++f) {
    const std::string name = "frame_000" + std::to_string(f) + ".png";
    EXPECT_EQ(ReadFile(folder_ / "animation/textures" / name), ReadFile(folder_ / "out" / name));
  }
  fs::remove(folder_ / "out/frame_0001.png");
  EXPECT_EQ(Run("export", "--frames frames --textures out --animation again --formats obj"), 3);
  EXPECT_TRUE(Says("no texture of frame 1")) << log_;
}

TEST_F(Video3d, CamerasThatAreLeftOutAreComparedAndMayBeTheFilmsView) {
  ASSERT_EQ(RunVideo3d("--cameras cam1,cam2,cam4,cam5 --film left_out.mp4 --view cam3"), 0) << log_;
  EXPECT_GT(fs::file_size(folder_ / "left_out.mp4"), 1000u);
  const auto report = nlohmann::json::parse(ReadFile(folder_ / "report.json"))["measurements"];
  ASSERT_EQ(report["other_cameras"].size(), 1u);
  EXPECT_EQ(report["other_cameras"][0]["name"], "cam3");
  // 19.3 dB here, at 96 pixels, with parts of the ball that only cam3 sees.
  EXPECT_GT(report["other_cameras"][0]["psnr_db"].get<double>(), 17);
  EXPECT_GT(report["other_cameras"][0]["covered"].get<double>(), 0.9);
}

TEST_F(Video3d, CameraThatDoesNotOverlapIsNamed) {
  std::vector<View> views = world_.views;
  const Eigen::Quaterniond away(Eigen::AngleAxisd(3.14159, Eigen::Vector3d::UnitY()));
  Rigid3& pose = views[2].camera_from_world;  // looks the other way
  pose.rotation = away * pose.rotation, pose.translation = away * pose.translation;
  WriteCalibration(views);
  EXPECT_EQ(RunVideo3d(), 3);
  EXPECT_TRUE(Says("camera cam3 does not see the moving mesh")) << log_;
  EXPECT_TRUE(Says("leave it out with --cameras")) << log_;
  EXPECT_EQ(RunVideo3d("--cameras cam1,cam2,cam4,cam5"), 0) << log_;
}

TEST_F(Video3d, CameraInMillimetresAmongMetresIsNamed) {
  std::vector<View> views = world_.views;
  // Turned as well as scaled about the origin, it would still look at the ball: moved aside first.
  for (View& view : views) view.camera_from_world.translation.x() += 0.05;
  views[1].camera_from_world.translation *= 1000;
  WriteCalibration(views);
  EXPECT_EQ(RunVideo3d(), 3);
  EXPECT_TRUE(Says("cam2 does not see the moving mesh")) << log_;
  EXPECT_TRUE(Says("millimetres among metres")) << log_;
}

TEST_F(Video3d, FramesInAnotherSpaceAreRefused) {
  for (int f = 0; f < kFrames; ++f) {
    Mesh frame = ReadMesh(folder_ / "frames" / FrameFileName(f));
    frame.points.col(2).array() += 100;
    WriteMesh(folder_ / "frames" / FrameFileName(f), frame);
  }
  EXPECT_EQ(RunVideo3d(), 3);
  EXPECT_TRUE(Says("--space template")) << log_;
  for (int f = 0; f < kFrames; ++f) {  // in the pictures, but beside the actor
    Mesh frame = ReadMesh(folder_ / "frames" / FrameFileName(f));
    frame.points = 0.3 * frame.points;
    frame.points.col(2).array() += 1.2 - 30;
    WriteMesh(folder_ / "frames" / FrameFileName(f), frame);
  }
  EXPECT_EQ(RunVideo3d(), 3);
  EXPECT_TRUE(Says("not where the films show the actor")) << log_;
}

TEST_F(Video3d, ShortFilmIsToldAndPaintedFromTheOthers) {
  fs::remove(folder_ / "shot/cam4/2.png"), fs::remove(folder_ / "shot/masks/cam4/2.png");
  ASSERT_EQ(RunVideo3d(), 0) << log_;
  EXPECT_TRUE(Says("films end before the motion does: cam4 (2 of 3)")) << log_;
  EXPECT_TRUE(fs::exists(folder_ / "out/frame_0002.png"));
}

TEST_F(Video3d, ClocksOffsetsAreFollowed) {
  WriteFile(folder_ / "clocks.json", R"({"offsets": {"cam2": 1}})");
  ASSERT_EQ(RunVideo3d("--clocks clocks.json"), 0) << log_;
  EXPECT_TRUE(Says("cam2 (2 of 3)")) << log_;
  WriteFile(folder_ / "clocks.json", R"({"offsets": {"cam2": "late"}})");
  EXPECT_EQ(RunVideo3d("--clocks clocks.json"), 3);
  EXPECT_TRUE(Says("cam2 is not a whole number")) << log_;
}

TEST_F(Video3d, ClocksThatNameNoFilmLeaveTheirTimes) {
  if (!CanWriteMp4()) GTEST_SKIP() << "libavcodec has no x264 here";
  for (const View& view : world_.views) {
    fs::remove_all(folder_ / "shot" / view.name);
    Mp4Writer film(folder_ / "shot" / (view.name + ".mp4"), view.camera.width, view.camera.height,
                   25);
    for (int f = 0; f < kFrames; ++f) film.Add(world_.Picture(view, f));
    film.Finish();
  }
  WriteFile(folder_ / "clocks.json", R"({"offsets": {}, "films": {}})");
  EXPECT_EQ(RunVideo3d("--clocks clocks.json"), 0) << log_;
  EXPECT_TRUE(fs::exists(folder_ / "out/frame_0002.png"));
}

TEST_F(Video3d, FramesWithoutTextureCoordinatesNeedALayout) {
  Mesh bare = world_.mesh;
  bare.uvs.resize(0, 2), bare.uv_faces.resize(0, 3);
  for (int f = 0; f < kFrames; ++f) {
    bare.points = world_.Points(f);
    WriteMesh(folder_ / "frames" / FrameFileName(f), bare);
  }
  EXPECT_EQ(RunVideo3d(), 3);
  EXPECT_TRUE(Says("keypose unwrap")) << log_;
  WriteMesh(folder_ / "layout.obj", world_.mesh);
  EXPECT_EQ(RunVideo3d("--layout layout.obj"), 0) << log_;
}

TEST_F(Video3d, FaultsOfCamerasAndViewsAreNamed) {
  EXPECT_EQ(RunVideo3d("--cameras cam1,cam9"), 2);
  EXPECT_TRUE(Says("cam9")) << log_;
  EXPECT_EQ(RunVideo3d("--film x.mp4 --view cam77"), 2);
  EXPECT_TRUE(Says("neither orbit nor a camera")) << log_;
  WriteFile(folder_ / "path.json", R"({"keys": [{"frame": 0}]})");
  EXPECT_EQ(RunVideo3d("--film x.mp4 --camera_path path.json"), 3);
  EXPECT_TRUE(Says("path.json: key 0")) << log_;
  WriteCalibration({world_.views[0], world_.views[1]});
  EXPECT_EQ(RunVideo3d(), 3);
  EXPECT_TRUE(Says("the calibration has no camera cam3, cam4, cam5")) << log_;
  WriteCalibration(world_.views);
  WriteImage(folder_ / "shot/cam1/0.png", Image8(90, 50, 3, 7));
  EXPECT_EQ(RunVideo3d(), 3);
  EXPECT_TRUE(Says("camera cam1")) << log_;
}

}  // namespace keypose::motion::video3d_program_test
