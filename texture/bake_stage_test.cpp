// The program keypose-bake on files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
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

/// Writes mesh, photographs with masks, and cameras as the stage takes them.
Scene WriteInputs(const std::filesystem::path& folder, const Paint& paint, bool deep) {
  std::filesystem::create_directories(folder / "images/masks");
  const Mesh mesh = PatchSphere(6);
  Scene scene{AllRound(90, 4), {}};
  const std::vector<Photograph> photographs = Shoot(mesh, scene.views, paint, deep);
  ImageSet set;
  set.folder = folder / "images";
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const std::string name = scene.views[v].name, mask = "masks/" + name + ".png";
    if (deep)
      WriteImage(set.folder / name, photographs[v].deep);
    else
      WriteImage(set.folder / name, photographs[v].image);
    WriteImage(set.folder / mask, photographs[v].mask);
    CapturedImage image;
    image.name = name;
    image.mask = mask;
    image.width = scene.views[v].camera.width;
    image.height = scene.views[v].camera.height;
    set.images.push_back(image);
  }
  std::sort(set.images.begin(), set.images.end(),
            [](const CapturedImage& a, const CapturedImage& b) { return a.name < b.name; });
  WriteImageSet(set);
  WriteMesh(folder / "mesh.obj", mesh);
  std::filesystem::create_directories(folder / "model");
  WriteColmapModel(folder / "model", scene);
  return scene;
}

TEST(BakeStage, PaintsFromFilesAndNamesTheViewThatHasNoImage) {
  const TestingFolder own;
  const std::filesystem::path folder = own.path();
  Scene scene = WriteInputs(folder, Smooth, false);
  const Mesh mesh = PatchSphere(6);
  ASSERT_EQ(RunBake(folder), 0) << ReadFile(folder / "log");
  EXPECT_GT(PsnrAgainst(mesh, ReadImage(folder / "texture.png", 3), Smooth), 34);
  EXPECT_EQ(StoredLevelsOf(folder / "texture.png").bits, 8);
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

TEST(BakeStage, SixteenBitsOfPhotographsReachTheCompletedTexture) {
  const TestingFolder own;
  const std::filesystem::path folder = own.path();
  // Two of 255 levels, from below to above.
  WriteInputs(
      folder,
      [](const Vector3d& x, const Vector3d&) -> Vector3f {
        return Vector3f::Constant(0.13f + 0.003f * static_cast<float>(x.z()));
      },
      true);
  const std::string confidence = " --confidence " + (folder / "sure.png").string();
  ASSERT_EQ(RunBake(folder, "texture.png", confidence), 0) << ReadFile(folder / "log");
  const std::string f = folder.string();
  ASSERT_EQ(std::system((BinFolder() + "/keypose-complete --mesh " + f + "/mesh.obj --texture " +
                         f + "/texture.png --confidence " + f + "/sure.png --completed " + f +
                         "/completed.png > " + f + "/log 2>&1")
                            .c_str()),
            0)
      << ReadFile(folder / "log");
  const Image16 texture = ReadAsStored(folder / "texture.png").sixteen,
                completed = ReadAsStored(folder / "completed.png").sixteen;
  ASSERT_EQ(texture.width, 128);
  EXPECT_GT(std::set<int>(texture.data.begin(), texture.data.end()).size(), 200u);
  const Image8 sure = ReadImage(folder / "sure.png", 1);
  for (std::size_t i = 0; i < completed.data.size(); ++i)
    if (sure.data[i / 3] == 255) {
      ASSERT_EQ(completed.data[i], texture.data[i]) << i;
    }
  ASSERT_EQ(RunBake(folder, "texture.png", "--bits 8"), 0) << ReadFile(folder / "log");
  EXPECT_EQ(StoredLevelsOf(folder / "texture.png").bits, 8);
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
