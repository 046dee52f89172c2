// The program keypose-bake on files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "texture/bake/testing_spheres.h"

namespace keypose::texture::bake_stage_test {

/// The stage's program on files.
/// @return its exit code
int RunBake(const std::filesystem::path& folder, const std::string& texture = "texture.png",
            const std::string& options = "") {
  const std::string f = folder.string();
  const std::string command = BinFolder() + "/keypose-bake --mesh " + f + "/mesh.obj --images " +
                              f + "/images --model " + f + "/model --texture_size 128 --texture " +
                              f + "/" + texture + " " + options + " --report " + f +
                              "/report.json > " + f + "/log 2>&1";
  return std::system(command.c_str()) >> 8;
}

TEST(BakeStage, PaintsFromFilesAndNamesTheViewThatHasNoImage) {
  const TestingFolder own;
  const std::filesystem::path folder = own.path();
  std::filesystem::create_directories(folder / "images/masks");
  const Mesh mesh = PatchSphere(6);
  Scene scene{AllRound(90, 4), {}};
  const std::vector<Photograph> photographs = Shoot(mesh, scene.views, Smooth);
  ImageSet set;
  set.folder = folder / "images";
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const std::string name = scene.views[v].name, mask = "masks/" + name + ".png";
    WriteImage(set.folder / name, photographs[v].image);
    WriteImage(set.folder / mask, photographs[v].mask);
    CapturedImage image;
    image.name = name;
    image.mask = mask;
    image.width = photographs[v].image.width;
    image.height = photographs[v].image.height;
    set.images.push_back(image);
  }
  std::sort(set.images.begin(), set.images.end(),
            [](const CapturedImage& a, const CapturedImage& b) { return a.name < b.name; });
  WriteImageSet(set);
  WriteMesh(folder / "mesh.obj", mesh);
  std::filesystem::create_directories(folder / "model");
  WriteColmapModel(folder / "model", scene);
  ASSERT_EQ(RunBake(folder), 0) << ReadFile(folder / "log");
  EXPECT_GT(PsnrAgainst(mesh, ReadImage(folder / "texture.png", 3), Smooth), 34);
  EXPECT_THAT(ReadFile(folder / "report.json"), ::testing::HasSubstr("\"unseen_fraction\""));
  ASSERT_EQ(RunBake(folder, "texture.exr"), 0) << ReadFile(folder / "log");
  EXPECT_EQ(ReadFile(folder / "texture.exr").substr(0, 4), "v/1\x01");
  ASSERT_EQ(RunBake(folder, "texture.tif"), 0) << ReadFile(folder / "log");
  EXPECT_GT(PsnrAgainst(mesh, ReadImage(folder / "texture.tif", 3), Smooth), 34);
  EXPECT_EQ(RunBake(folder, "texture.exr", "--bits 8"), 2);
  scene.views[2].name = "elsewhere.png";
  WriteColmapModel(folder / "model", scene);
  std::filesystem::remove(folder / "texture.png");
  EXPECT_EQ(RunBake(folder), 3);
  EXPECT_THAT(ReadFile(folder / "log"), ::testing::HasSubstr("elsewhere.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "texture.png"));
}

TEST(BakeStage, TakesTheColoursOfAScanInPlaceOfPhotographs) {
  const TestingFolder own;
  const std::string f = own.path().string();
  const Mesh mesh = PatchSphere(6);
  WriteMesh(own.path() / "mesh.obj", mesh);
  WriteImage(own.path() / "skin.png", Image8(64, 64, 3, 140));
  const auto bake = [&](const std::string& from) {
    return std::system((BinFolder() + "/keypose-bake --mesh " + f + "/mesh.obj " + from +
                        " --texture_size 64 --texture " + f + "/texture.png --report " + f +
                        "/report.json > " + f + "/log 2>&1")
                           .c_str()) >>
           8;
  };
  const std::string scan = "--scan " + f + "/mesh.obj ";
  ASSERT_EQ(bake(scan + "--scan_texture " + f + "/skin.png"), 0) << ReadFile(f + "/log");
  EXPECT_EQ(ReadImage(f + "/texture.png", 3).data, Image8(64, 64, 3, 140).data);
  EXPECT_THAT(ReadFile(f + "/report.json"), ::testing::HasSubstr("\"unseen_fraction\": 0"));
  EXPECT_EQ(bake(scan), 0);
  EXPECT_THAT(ReadFile(f + "/log"), ::testing::HasSubstr("no colours of its vertices"));
  EXPECT_EQ(bake(""), 2) << "from what?";
  EXPECT_EQ(bake(scan + "--images " + f + " --model " + f), 2) << "both";
  Mesh elsewhere = mesh;
  elsewhere.points.col(0).array() += 9;
  WriteMesh(own.path() / "far.obj", elsewhere);
  ASSERT_EQ(bake("--scan " + f + "/far.obj --scan_texture " + f + "/skin.png"), 0);
  EXPECT_THAT(ReadFile(f + "/log"), ::testing::HasSubstr("nowhere near"));
}

}  // namespace keypose::texture::bake_stage_test
