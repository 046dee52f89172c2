// The program keypose-follow, as a user starts it.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/testing/cut_in_charts.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/size_of.h"
#include "fit/testing/breathing_ball.h"

namespace keypose::fit::follow_program_test {

namespace fs = std::filesystem;

constexpr int kFilmed = 3;

class Follow : public ::testing::Test, public TestingFolder {
 protected:
  Follow() {
    fs::create_directories(folder_ / "frames");
    for (int f = 0; f < kFilmed; ++f) WriteFrame(f, world_.mesh.points);
    for (int v = 0; v < kCameras; ++v)
      for (int f = 0; f < kFilmed; ++f) WriteFilmed(v, f);
    WriteCalibration(world_.views);
  }

  void WriteFrame(int f, const PointsX3& points) const {
    Mesh frame = world_.mesh;
    frame.points = points;
    WriteMesh(folder_ / "frames" / FrameFileName(f), frame);
  }
  void WriteFilmed(int v, int f) const {
    const std::string camera = world_.views[v].name, number = std::to_string(f) + ".png";
    fs::create_directories(folder_ / "shot" / camera);
    fs::create_directories(folder_ / "shot/masks" / camera);
    WriteImage(folder_ / "shot" / camera / number, world_.Picture(v, f));
    WriteImage(folder_ / "shot/masks" / camera / number, world_.Mask(v, f));
  }
  void WriteCalibration(const std::vector<View>& views) const {
    WriteFile(folder_ / "rig.yml", OpenCvYaml(views));
  }
  int Run(const std::string& more = "") {
    const std::string command =
        "cd '" + folder_.string() + "' && '" + BinFolder() +
        "/keypose-follow' --frames frames --video shot --calibration rig.yml --followed out "
        "--overwrite --report report.json " +
        more + " > log.txt 2>&1";
    const int status = std::system(command.c_str());
    log_ = ReadFile(folder_ / "log.txt");
    return WEXITSTATUS(status);
  }
  bool Says(const std::string& words) const { return log_.find(words) != std::string::npos; }

  static constexpr int kCameras = 4;
  BreathingBall world_{kCameras};
  std::string log_;
};

TEST_F(Follow, BendsFramesIntoTheFilms) {
  ASSERT_EQ(Run("--confidence sure.ply --picture seen.jpg --stiffness 0.8 --calm 0.5 --vertices "
                "2000 --max_size 140 --cameras cam1,cam2,cam3,cam4 --volume false"),
            0)
      << log_;
  for (int f = 0; f < kFilmed; ++f) {
    const Mesh frame = ReadMesh(folder_ / "out" / FrameFileName(f));
    EXPECT_EQ(frame.faces, world_.mesh.faces);
    EXPECT_LT(world_.Error(frame.points, f), 0.65 * world_.Error(world_.mesh.points, f));
  }
  EXPECT_TRUE(fs::exists(folder_ / "out/distortion.json"));
  EXPECT_TRUE(fs::exists(folder_ / "seen.jpg"));
  EXPECT_EQ(ReadMesh(folder_ / "sure.ply").colors.rows(), world_.mesh.vertex_count());
  const auto report = nlohmann::json::parse(ReadFile(folder_ / "report.json"))["measurements"];
  EXPECT_EQ(report["frames"], kFilmed);
  EXPECT_EQ(report["per_frame"].size(), static_cast<std::size_t>(kFilmed));
  EXPECT_GT(report["iou_mean"], 0.96);
  EXPECT_LT(report["iou_before_mean"], 0.93);
  EXPECT_GT(report["volume_ratio"], 0.99);
  EXPECT_EQ(report["flipped"], 0);
}

TEST_F(Follow, OutlinesAloneKeepTheVolumeInTime) {
  ASSERT_EQ(Run("--grey false"), 0) << log_;
  const auto volume = [&](int f) {
    const Mesh frame = ReadMesh(folder_ / "out" / FrameFileName(f));
    return SignedVolume(frame.points, frame.faces);
  };
  for (int f = 1; f < kFilmed; ++f) EXPECT_NEAR(volume(f) / volume(0), 1, 1e-6);
  EXPECT_GT(volume(0), 1.1 * SignedVolume(world_.mesh.points, world_.mesh.faces));
}

TEST_F(Follow, FramesThatAreCutForTheirTextureBendAsTheWholeOnes) {
  std::vector<int> origin;
  const Mesh cut = CutInCharts(world_.mesh, 0.5 * world_.mesh.points.col(2).maxCoeff(), &origin);
  ASSERT_GT(SizeOf(origin), world_.mesh.vertex_count());
  ASSERT_EQ(Run("--grey false"), 0) << log_;
  const Mesh whole = ReadMesh(folder_ / "out" / FrameFileName(1));
  for (int f = 0; f < kFilmed; ++f) WriteMesh(folder_ / "frames" / FrameFileName(f), cut);
  ASSERT_EQ(Run("--grey false --confidence sure.ply"), 0) << log_;
  const Mesh bent = ReadMesh(folder_ / "out" / FrameFileName(1));
  EXPECT_EQ(bent.faces, cut.faces);
  // Vertices have other numbers, so that sums differ in their order.
  const double size = BoundingDiagonal(whole.points);
  const PointsX3 difference = bent.points - PointsX3(whole.points(origin, Eigen::all));
  EXPECT_LT(difference.rowwise().norm().mean(), 2e-3 * size);
  for (int v = 0; v < SizeOf(origin); ++v)
    for (int w = 0; w < v; ++w)
      if (origin[v] == origin[w]) {
        ASSERT_EQ(bent.points.row(v), bent.points.row(w));
      }
  EXPECT_EQ(ReadMesh(folder_ / "sure.ply").colors.rows(), cut.vertex_count());
}

TEST_F(Follow, FramesInAnotherSpaceAreRefused) {
  for (int f = 0; f < kFilmed; ++f)
    WriteFrame(f, (0.3 * world_.mesh.points).rowwise() + Eigen::RowVector3d(0, 0, 3));
  EXPECT_EQ(Run(), 3);
  EXPECT_TRUE(Says("not where the films show the actor")) << log_;
  EXPECT_TRUE(Says("--space template")) << log_;
}

TEST_F(Follow, CameraThatLooksElsewhereIsNamed) {
  std::vector<View> views = world_.views;
  views[2].camera_from_world.translation.x() += 2;
  WriteCalibration(views);
  EXPECT_EQ(Run(), 3);
  EXPECT_TRUE(Says("camera cam3 shows the actor where the mesh is not")) << log_;
}

TEST_F(Follow, FaultsOfFilmsAndMeshesAreNamed) {
  fs::rename(folder_ / "shot/masks/cam2", folder_ / "cam2");
  EXPECT_EQ(Run(), 3);
  EXPECT_TRUE(Says("no masks of camera cam2")) << log_;
  EXPECT_TRUE(Says("keypose silhouettes")) << log_;
  fs::rename(folder_ / "cam2", folder_ / "shot/masks/cam2");
  WriteFile(folder_ / "clocks.json",
            R"({"offsets": {"cam1": 9, "cam2": 9, "cam3": 9, "cam4": 9}})");
  EXPECT_EQ(Run("--clocks clocks.json"), 3);
  EXPECT_TRUE(Says("no film has a frame of this motion")) << log_;
  EXPECT_EQ(Run("--cameras cam1"), 3);
  EXPECT_TRUE(Says("one camera does not tell depth")) << log_;
  WriteImage(folder_ / "texture.png", Image8(8, 8, 3, 90));
  EXPECT_EQ(Run("--texture texture.png"), 3);
  EXPECT_TRUE(Says("pass --layout")) << log_;
  Mesh other = world_.mesh;
  other.faces.conservativeResize(other.faces.rows() - 1, 3);
  WriteMesh(folder_ / "frames" / FrameFileName(1), other);
  EXPECT_EQ(Run(), 3);
  EXPECT_TRUE(Says("frame_0001.ply does not have the faces of the first frame")) << log_;
}

TEST_F(Follow, ShortFilmIsToldAndFittedFromTheOthers) {
  fs::remove(folder_ / "shot/cam4/2.png"), fs::remove(folder_ / "shot/masks/cam4/2.png");
  ASSERT_EQ(Run("--grey false --vertices 300"), 0) << log_;
  EXPECT_TRUE(Says("films end before the motion does: cam4 (2 of 3)")) << log_;
  EXPECT_TRUE(Says("fitted from the other cameras")) << log_;
  EXPECT_TRUE(fs::exists(folder_ / "out" / FrameFileName(2)));
}

}  // namespace keypose::fit::follow_program_test
