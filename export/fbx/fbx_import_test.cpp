// FBX files in programs that are not ours: Blender and three.js.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "export/caches/testing/polygon_scene.h"
#include "export/caches/testing/run_reader.h"
#include "export/caches/testing/test_scene.h"
#include "export/fbx/fbx.h"

namespace keypose::exporting::fbx_import_test {

using ::testing::HasSubstr;

const std::string kTesting = SourceFolder() + "/export/fbx/testing/";

/// The file of a scene, alone in a folder, and beside it what readers must find.
class Imported {
 public:
  explicit Imported(const Scene& scene) {
    WriteFile(path(), MakeFbx(scene, nullptr).files.at(0).bytes);
    WriteTruth(scene, folder_.path() / "truth");
  }
  std::filesystem::path path() const { return folder_.path() / "character.fbx"; }

  /// @param stands  per shown frame but the last, whether it is held until the next
  ReaderResult InBlender(const std::string& stands) const {
    return RunReader({"blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                      kTesting + "check_fbx.py", "--", path(), folder_.path() / "truth", stands});
  }
  ReaderResult InThree() const {
    return RunReader({"node", kTesting + "check_fbx.mjs", path(), folder_.path() / "truth"});
  }

 private:
  TestingFolder folder_;
};

bool HasThree() {
  return HasReader("node") &&
         std::filesystem::exists(SourceFolder() + "/node_modules/three/package.json");
}

/// A picture that stands, pictures that blend, and two on twos.
TestSceneOptions GlidesAndSteps() {
  TestSceneOptions options;
  options.bends = {0, 0, 1, 2, 2, 5, 5, 6};
  options.stands = {1, 1, 0, 1, 1, 1, 1, 0};
  options.playback = {24, 0, "none"};
  return options;
}

void ExpectFramesInPlace(const ReaderResult& result, std::size_t frames) {
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(FigureOf(result.output, "frames"), frames);
  EXPECT_LT(FigureOf(result.output, "error_over_diagonal"), 1e-6) << result.output;
}

TEST(FbxInBlender, EveryFrameCornerAndTheTextureAreInPlace) {
  if (!HasReader("blender")) GTEST_SKIP() << "Blender is not installed";
  const Scene scene = TestScene(GlidesAndSteps());
  const ReaderResult result = Imported(scene).InBlender("1101111");
  ExpectFramesInPlace(result, 8);
  EXPECT_GT(FigureOf(result.output, "moved_over_diagonal"), 0.1);
  EXPECT_LT(FigureOf(result.output, "between_over_diagonal"), 1e-6);
  EXPECT_LT(FigureOf(result.output, "uv_error"), 1e-6);
  EXPECT_LT(FigureOf(result.output, "normal_error"), 1e-3) << "Blender keeps them in 16 bits";
  EXPECT_EQ(FigureOf(result.output, "fps"), 24);
  EXPECT_EQ(FigureOf(result.output, "scale"), 0);
  EXPECT_NEAR(FigureOf(result.output, "roughness"), 0.9, 1e-6);
  EXPECT_EQ(FigureOf(result.output, "alpha"), 1);
  EXPECT_THAT(result.output, HasSubstr("object=character mesh=character materials=clay\n"));
  EXPECT_THAT(result.output, HasSubstr("shape_keys=frame_0002,frame_0003,frame_0005,frame_0007\n"));
  EXPECT_THAT(result.output, HasSubstr("images=1 shown=1\n"));
  EXPECT_THAT(result.output, HasSubstr("image=bands packed=1 width=64 height=64 "
                                       "lower_left=60,90,249 upper_right=249,170,60\n"));
}

/// Frames with y up, held at both ends, there and back.
TestSceneOptions ThereAndBack(double fps) {
  TestSceneOptions options;
  options.bends = {0, 3, 7};
  options.playback = {fps, 2, "pingpong"};
  options.z_up = false;
  options.with_uvs = false;
  return options;
}

// Blender 3.4 rounds frame rates where it places keys; at a whole rate that changes nothing.
TEST(FbxInBlender, PingpongHoldsAndARateThatIsNoModeAreKept) {
  if (!HasReader("blender")) GTEST_SKIP() << "Blender is not installed";
  Scene scene = TestScene(ThereAndBack(15));
  scene.name = "Knetkatze Ü";
  const ReaderResult result = Imported(scene).InBlender("00000000");
  ExpectFramesInPlace(result, ShownFrames(scene).size());
  EXPECT_LT(FigureOf(result.output, "between_over_diagonal"), 1e-6);
  EXPECT_EQ(FigureOf(result.output, "fps"), 15);
  EXPECT_EQ(FigureOf(result.output, "uv_layers"), 0);
  EXPECT_THAT(result.output, HasSubstr("object=Knetkatze Ü "));
  EXPECT_THAT(result.output, HasSubstr("actions=Key|Knetkatze Ü\n"));
}

TEST(FbxInBlender, OnePictureIsAPlainMesh) {
  if (!HasReader("blender")) GTEST_SKIP() << "Blender is not installed";
  TestSceneOptions options;
  options.bends = {4, 4};
  const ReaderResult result = Imported(TestScene(options)).InBlender("1");
  ExpectFramesInPlace(result, 2);
  EXPECT_THAT(result.output, HasSubstr("shape_keys=\nactions=\n"));
}

TEST(FbxInBlender, QuadsAndPolygonsComeOutAsTheyWentIn) {
  if (!HasReader("blender")) GTEST_SKIP() << "Blender is not installed";
  const BlenderFaces found = ReadInBlender(Imported(LanternScene()).path());
  EXPECT_EQ(found.faces, 24);
  EXPECT_EQ(found.triangles, 1);
  EXPECT_EQ(found.quads, 18);
  EXPECT_EQ(found.pentagons, 1);
  EXPECT_EQ(found.hexagons, 2);
  EXPECT_EQ(found.heptagons, 2);
  const NamedFaces given = FacesOfObj(LanternObj());
  EXPECT_EQ(found.vertices, given.vertices);
  EXPECT_THAT(found.uvs, ::testing::Pointwise(::testing::DoubleNear(2e-5), given.uvs));
}

TEST(FbxInThree, EveryFrameAndCornerIsInPlace) {
  if (!HasThree()) GTEST_SKIP() << "node or node_modules/three is missing: run ./dev setup";
  const Scene scene = TestScene(GlidesAndSteps());
  const ReaderResult result = Imported(scene).InThree();
  ExpectFramesInPlace(result, 8);
  EXPECT_LT(FigureOf(result.output, "uv_error"), 1e-6);
  EXPECT_EQ(FigureOf(result.output, "targets"), 4);
  EXPECT_NEAR(FigureOf(result.output, "seconds"), 8.0 / 24, 1e-6);
  EXPECT_EQ(FigureOf(result.output, "images"), 1);
  EXPECT_EQ(FigureOf(result.output, "map"), 1);
  EXPECT_EQ(FigureOf(result.output, "unit"), 100);
}

TEST(FbxInThree, FractionalRateIsKept) {
  if (!HasThree()) GTEST_SKIP() << "node or node_modules/three is missing: run ./dev setup";
  const Scene scene = TestScene(ThereAndBack(12.5));
  const ReaderResult result = Imported(scene).InThree();
  ExpectFramesInPlace(result, 9);
  EXPECT_NEAR(FigureOf(result.output, "seconds"), 8 / 12.5, 1e-6);
}

}  // namespace keypose::exporting::fbx_import_test
