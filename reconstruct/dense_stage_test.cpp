// The program keypose-dense: its ports, report and exit codes.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "reconstruct/testing/rendered_ring.h"

namespace keypose::reconstruct::dense_stage_test {

namespace fs = std::filesystem;

// A small rendered ring on disk, as capture and sfm leave one.
class DenseStage : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "images" / "masks");
    fs::create_directories(folder_ / "model");
    scene_ = testing::RenderRing({.views = 8, .size = 72});
    set_.folder = folder_ / "images";
    for (std::size_t i = 0; i < scene_.images.size(); ++i) {
      const std::string name = scene_.scene.views[i].name;
      WriteImage(set_.folder / name, scene_.images[i]);
      WriteImage(set_.folder / "masks" / (name + ".png"), scene_.masks[i]);
      CapturedImage& image = set_.images.emplace_back();
      image.name = name, image.width = image.height = 72, image.mask = "masks/" + name + ".png";
    }
    WriteImageSet(set_);
    WriteColmapModel(folder_ / "model", scene_.scene);
  }

  int Run(const std::string& more = "") {
    const std::string command = "cd '" + folder_.string() + "' && '" + BinFolder() +
                                "/keypose-dense' --images images --model model --cloud cloud.ply " +
                                "--report report.json --hull_resolution 64 " + more +
                                " >log.txt 2>&1";
    const int status = std::system(command.c_str());
    log_ = ReadFile(folder_ / "log.txt");
    return WEXITSTATUS(status);
  }

  testing::RenderedScene scene_;
  ImageSet set_;
  std::string log_;
};

TEST_F(DenseStage, WritesACloudAndItsMeasurements) {
  ASSERT_EQ(Run(), 0) << log_;
  const PointCloud cloud = ReadPointCloud(folder_ / "cloud.ply");
  const nlohmann::json m = nlohmann::json::parse(ReadFile(folder_ / "report.json"))["measurements"];
  EXPECT_EQ(m["points"], cloud.points.rows());
  EXPECT_EQ(m["views"], 16);
  EXPECT_GT(m["stereo_points"], 1000);
  EXPECT_GT(m["cpu_seconds"], 0);
  EXPECT_GT(m["ncc_evaluations"], 100000);
  EXPECT_EQ(m["completeness"].size(), 16u);
  ASSERT_EQ(cloud.normals.rows(), cloud.points.rows());
  ASSERT_EQ(cloud.colors.rows(), cloud.points.rows());
  ASSERT_EQ(cloud.confidence.rows(), cloud.points.rows());
  EXPECT_LT(testing::Measure(scene_, cloud, m["stereo_points"]).footprints_90, 1.5);
}

TEST_F(DenseStage, ImageOfTheModelThatIsNotInTheFolderIsNamed) {
  set_.images.erase(set_.images.begin() + 3);
  WriteImageSet(set_);
  EXPECT_EQ(Run(), 3);
  EXPECT_NE(log_.find(scene_.scene.views[3].name), std::string::npos) << log_;
  EXPECT_FALSE(fs::exists(folder_ / "cloud.ply"));
}

TEST_F(DenseStage, BlackMasksAreAnInputErrorThatNamesThem) {
  for (const CapturedImage& image : set_.images)
    WriteImage(set_.folder / image.mask, Image8(72, 72, 1));
  EXPECT_EQ(Run(), 3);
  EXPECT_NE(log_.find("mask"), std::string::npos) << log_;
  EXPECT_NE(log_.find(set_.images[0].name), std::string::npos) << log_;
}

TEST_F(DenseStage, MaskOfAnotherSizeIsAnInputError) {
  WriteImage(set_.folder / set_.images[5].mask, Image8(60, 72, 1, 255));
  EXPECT_EQ(Run(), 3);
  EXPECT_NE(log_.find(set_.images[5].name), std::string::npos) << log_;
}

TEST_F(DenseStage, ColmapWithoutCudaIsAToolError) {
  WriteFile(folder_ / "colmap",
            "#!/bin/sh\necho 'COLMAP 3.8 (Commit Unknown on Unknown without CUDA)'\n");
  fs::permissions(folder_ / "colmap", fs::perms::owner_all);
  setenv("KEYPOSE_COLMAP", (folder_ / "colmap").c_str(), 1);
  EXPECT_EQ(Run("--backend colmap_cuda"), 5);
  unsetenv("KEYPOSE_COLMAP");
  EXPECT_NE(log_.find("CUDA"), std::string::npos) << log_;
}

TEST_F(DenseStage, ColmapWithCudaIsRunAndItsPointsAreCutToTheHull) {
  // Replaces a CUDA build: fuses one point on the object and one far away.
  PointCloud cloud;
  cloud.points.resize(2, 3), cloud.points << 0, 0, 0.9, 30, 0, 0;
  cloud.normals.resize(2, 3), cloud.normals << 0, 0, 1, 0, 0, 1;
  cloud.colors.resize(2, 3), cloud.colors << 1, 2, 3, 4, 5, 6;
  WritePointCloud(folder_ / "made.ply", cloud);
  WriteFile(folder_ / "colmap",
            "#!/bin/sh\necho \"COLMAP (with CUDA) $@\"\nlast=\"\"\nfor a in \"$@\"; do\n  [ "
            "\"$last\" = --output_path ] && "
            "[ \"$1\" = stereo_fusion ] && cp '" +
                (folder_ / "made.ply").string() + "' \"$a\"\n  last=\"$a\"\ndone\nexit 0\n");
  fs::permissions(folder_ / "colmap", fs::perms::owner_all);
  setenv("KEYPOSE_COLMAP", (folder_ / "colmap").c_str(), 1);
  const int status = Run("--backend colmap_cuda");
  unsetenv("KEYPOSE_COLMAP");
  ASSERT_EQ(status, 0) << log_;
  const PointCloud read = ReadPointCloud(folder_ / "cloud.ply");
  ASSERT_EQ(read.points.rows(), 1);
  EXPECT_NEAR(read.points(0, 2), 0.9, 1e-6);
}

}  // namespace keypose::reconstruct::dense_stage_test
