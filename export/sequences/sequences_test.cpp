// Numbered files, read by our reader and by Blender.
#include "export/sequences/sequences.h"
#include "core/testing/paths.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/io/meshes/mesh_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "export/caches/testing/polygon_scene.h"
#include "export/caches/testing/run_reader.h"
#include "export/caches/testing/test_scene.h"

namespace keypose::exporting::sequences_test {

namespace fs = std::filesystem;

std::vector<std::string> NamesIn(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// A hold at both ends, and the way back: 0 0 1 2 2 1 0.
Scene HeldScene() {
  TestSceneOptions options;
  options.bends = {0, 1, 2};
  options.playback = {10, 1, "pingpong"};
  return TestScene(options);
}

TEST(WriteObjSequence, HasAFileForEachPictureOfTheFilm) {
  const TestingFolder folder;
  const Scene scene = HeldScene();
  const WrittenSequence written = WriteObjSequence(scene, folder.path() / "obj", "", nullptr);
  EXPECT_EQ(written.files, 7);
  EXPECT_EQ(written.pictures, 3);
  EXPECT_EQ(NamesIn(folder.path() / "obj"),
            (std::vector<std::string>{"frame_0000.obj", "frame_0001.obj", "frame_0002.obj",
                                      "frame_0003.obj", "frame_0004.obj", "frame_0005.obj",
                                      "frame_0006.obj"}));
  const std::vector<int> shown{0, 0, 1, 2, 2, 1, 0};
  for (int i = 0; i < 7; ++i) {
    const Mesh read = ReadMesh(folder.path() / "obj" / ("frame_000" + std::to_string(i) + ".obj"));
    const PointsX3 wanted = WithYUp(scene.frames[shown[i]].points, true);
    ASSERT_EQ(read.points.rows(), wanted.rows());
    // tinyobjloader loses the last bits of some numbers.
    EXPECT_LT((read.points - wanted).cwiseAbs().maxCoeff(), 1e-14) << i;
    EXPECT_EQ(read.faces, scene.frames[0].faces);
  }
}

TEST(WriteObjSequence, NumbersGiveBackTheSameDouble) {
  const TestingFolder folder;
  EXPECT_EQ(WriteObjSequence(HeldScene(), folder.path(), "", nullptr).error_over_diagonal, 0);
}

TEST(WriteObjSequence, AllFilesShareOneMaterial) {
  const TestingFolder folder;
  WriteObjSequence(HeldScene(), folder.path(), "../textures/texture_0.png", nullptr);
  const std::vector<std::string> names = NamesIn(folder.path());
  EXPECT_EQ(names.size(), 8u);
  EXPECT_EQ(names[0], "character.mtl");
  EXPECT_NE(ReadFile(folder.path() / "character.mtl").find("map_Kd ../textures/texture_0.png\n"),
            std::string::npos);
  for (std::size_t i = 1; i < names.size(); ++i)
    EXPECT_EQ(ReadFile(folder.path() / names[i]).rfind("mtllib character.mtl\n", 0), 0u);
}

TEST(WriteObjSequence, MeshWithoutTextureCoordinatesHasNoMaterial) {
  const TestingFolder folder;
  TestSceneOptions options;
  options.with_uvs = false;
  WriteObjSequence(TestScene(options), folder.path(), "../textures/texture_0.png", nullptr);
  EXPECT_EQ(NamesIn(folder.path()).size(), 4u);
  EXPECT_EQ(ReadFile(folder.path() / "frame_0000.obj").find("mtllib"), std::string::npos);
}

TEST(WriteObjSequence, QuadsAndPolygonsComeOutAsTheyWentIn) {
  const TestingFolder folder;
  const Scene scene = LanternScene();
  const NamedFaces given = FacesOfObj(LanternObj());
  ASSERT_EQ(given.sizes.size(), 24u);
  EXPECT_EQ(std::count(given.sizes.begin(), given.sizes.end(), 4), 18);
  WriteObjSequence(scene, folder.path(), "", nullptr);
  for (const char* name : {"frame_0000.obj", "frame_0002.obj"}) {
    const NamedFaces written = FacesOfObj(ReadFile(folder.path() / name));
    EXPECT_EQ(written.sizes, given.sizes);
    EXPECT_EQ(written.vertices, given.vertices);
    EXPECT_EQ(written.uvs, given.uvs);
  }
  EXPECT_EQ(ReadMesh(folder.path() / "frame_0002.obj").points.rows(), 34);
}

TEST(WriteObjSequence, BlenderFindsTheQuadsAndPolygons) {
  if (!HasReader("blender")) GTEST_SKIP() << "blender is missing: run ./dev setup";
  const TestingFolder folder;
  WriteObjSequence(LanternScene(), folder.path(), "", nullptr);
  const BlenderFaces found = ReadInBlender(folder.path() / "frame_0001.obj");
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

TEST(WriteObjSequence, FramesWithYUpKeepTheirAxes) {
  const TestingFolder folder;
  TestSceneOptions options;
  options.z_up = false;
  const Scene scene = TestScene(options);
  WriteObjSequence(scene, folder.path(), "", nullptr);
  const PointsX3 read = ReadMesh(folder.path() / "frame_0003.obj").points;
  EXPECT_LT((read - scene.frames[3].points).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(WriteObjSequence, NamesOfMoreThanTenThousandFilesSortByNumber) {
  const TestingFolder folder;
  TestSceneOptions options;
  options.bends = {0};
  options.playback.hold = 10000;
  options.segments = 3, options.rings = 1;
  const WrittenSequence written = WriteObjSequence(TestScene(options), folder.path(), "", nullptr);
  EXPECT_EQ(written.files, 10001);
  const std::vector<std::string> names = NamesIn(folder.path());
  EXPECT_EQ(names.front(), "frame_00000.obj");
  EXPECT_EQ(names.back(), "frame_10000.obj");
}

TEST(WriteObjSequence, FolderThatCannotBeMadeThrows) {
  const TestingFolder folder;
  WriteFile(folder.path() / "taken", "a file");
  EXPECT_THROW(WriteObjSequence(HeldScene(), folder.path() / "taken", "", nullptr), DiskError);
  EXPECT_THROW(WritePlySequence(HeldScene(), folder.path() / "taken", nullptr), DiskError);
}

TEST(WritePlySequence, KeepsEveryBitOfEveryShownFrame) {
  const TestingFolder folder;
  const Scene scene = HeldScene();
  const WrittenSequence written = WritePlySequence(scene, folder.path() / "ply", nullptr);
  EXPECT_EQ(written.files, 7);
  EXPECT_EQ(written.pictures, 3);
  EXPECT_EQ(written.error_over_diagonal, 0);
  const std::vector<int> shown{0, 0, 1, 2, 2, 1, 0};
  for (int i = 0; i < 7; ++i) {
    const Mesh read = ReadMesh(folder.path() / "ply" / ("frame_000" + std::to_string(i) + ".ply"));
    EXPECT_EQ(read.points, scene.frames[shown[i]].points) << i;
    EXPECT_TRUE(read.has_uvs());
  }
}

TEST(WritePlySequence, TextureCoordinatesAreFloatAsMeshLabReadsThem) {
  const TestingFolder folder;
  const Scene scene = HeldScene();
  WritePlySequence(scene, folder.path(), nullptr);
  const std::string text = ReadFile(folder.path() / "frame_0000.ply");
  EXPECT_NE(text.find("property list uchar float texcoord\n"), std::string::npos);
  const Mesh read = ReadMesh(folder.path() / "frame_0000.ply"), &given = scene.frames[0];
  for (int f = 0; f < given.face_count(); ++f)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(read.uvs.row(read.uv_faces(f, k)),
                given.uvs.row(given.uv_faces(f, k)).cast<float>().cast<double>());
}

/// What Blender says of a written sequence.
std::string InBlender(const Scene& scene, const std::string& kind) {
  const TestingFolder folder;
  WriteTruth(scene, folder.path() / "truth");
  WriteFiles({}, scene, folder.path());  // the textures
  if (kind == "obj")
    WriteObjSequence(scene, folder.path() / kind, "../textures/texture_0.png", nullptr);
  else
    WritePlySequence(scene, folder.path() / kind, nullptr);
  const ReaderResult read =
      RunReader({"blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                 SourceFolder() + "/export/sequences/testing/check_sequence.py", "--",
                 (folder.path() / "truth").string(), (folder.path() / kind).string(), kind});
  EXPECT_EQ(read.exit_code, 0) << read.output;
  return read.output;
}

TEST(WriteObjSequence, StandsUprightAndTexturedInBlenderByDefault) {
  if (!HasReader("blender")) GTEST_SKIP() << "blender is missing: run ./dev setup";
  const std::string output = InBlender(HeldScene(), "obj");
  EXPECT_EQ(FigureOf(output, "files"), 7);
  EXPECT_LT(FigureOf(output, "worst"), 1e-6) << "single precision";
  EXPECT_LT(FigureOf(output, "uv"), 1e-6);
  EXPECT_EQ(FigureOf(output, "textures"), 7);
  EXPECT_EQ(FigureOf(output, "smooth"), 7);
}

TEST(WritePlySequence, StandsUprightInBlenderByDefault) {
  if (!HasReader("blender")) GTEST_SKIP() << "blender is missing: run ./dev setup";
  const std::string output = InBlender(HeldScene(), "ply");
  EXPECT_EQ(FigureOf(output, "files"), 7);
  EXPECT_LT(FigureOf(output, "worst"), 1e-6) << "single precision";
}

}  // namespace keypose::exporting::sequences_test
