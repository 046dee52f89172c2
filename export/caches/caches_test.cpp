// Point caches, decoded by hand and as Blender reads them.
#include "export/caches/caches.h"
#include "core/testing/paths.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <map>

#include "core/io/meshes/mesh_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "export/caches/testing/polygon_scene.h"
#include "export/caches/testing/run_reader.h"
#include "export/caches/testing/test_scene.h"

namespace keypose::exporting::caches_test {

namespace fs = std::filesystem;

/// A cache as the formats' descriptions say, independent of the code that writes it.
struct Cache {
  std::string bytes;
  bool big_endian = false;

  std::uint32_t Word(std::size_t at) const {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes.at(at + i)); };
    return big_endian ? byte(0) << 24 | byte(1) << 16 | byte(2) << 8 | byte(3)
                      : byte(3) << 24 | byte(2) << 16 | byte(1) << 8 | byte(0);
  }
  float Float(std::size_t at) const { return std::bit_cast<float>(Word(at)); }
};

const std::string& BytesOf(const FormatFiles& made, const std::string& path) {
  for (const FormatFile& file : made.files)
    if (file.path == path) return file.bytes;
  throw std::runtime_error("no file " + path);
}

/// The same animation with vertices numbered in the order in which its triangles first have them,
/// as Blender 3.4's importer does it unless it is told to keep the file's order.
Scene InFaceOrder(Scene scene) {
  std::map<int, int> place;
  std::vector<int> order;
  for (const Eigen::Vector3i face : scene.frames[0].faces.rowwise())
    for (const int vertex : face)
      if (place.emplace(vertex, SizeOf(order)).second) order.push_back(vertex);
  for (Mesh& frame : scene.frames) {
    frame.points = PointsX3(frame.points(order, Eigen::all));
    for (int& vertex : frame.faces.reshaped()) vertex = place.at(vertex);
  }
  scene.split = MakeAnimatedMesh(scene.frames, scene.frame_names);
  return scene;
}

void ExpectSamples(const Cache& cache, std::size_t at, const Scene& scene) {
  const std::vector<int> shown = ShownFrames(scene);
  const int vertices = scene.frames[0].vertex_count();
  ASSERT_EQ(cache.bytes.size(), at + 12 * shown.size() * vertices);
  for (const int frame : shown) {
    for (int v = 0; v < vertices; ++v, at += 12) {
      const Eigen::RowVector3d p = scene.frames[frame].points.row(v);
      const Eigen::RowVector3f expected =
          (scene.z_up ? Eigen::RowVector3d(p.x(), p.z(), -p.y()) : p).cast<float>();
      for (int c = 0; c < 3; ++c)
        ASSERT_EQ(cache.Float(at + 4 * c), expected[c]) << "frame " << frame << " vertex " << v;
    }
  }
}

TEST(MakePc2, HoldsEveryShownFrameToSinglePrecision) {
  TestSceneOptions options;
  options.playback = {25, 2, "pingpong"};
  const Scene scene = TestScene(options);
  const FormatFiles made = MakePc2(scene, nullptr);
  const Cache cache{BytesOf(made, "cache/character.pc2"), false};
  EXPECT_EQ(cache.bytes.substr(0, 12), std::string("POINTCACHE2\0", 12));
  EXPECT_EQ(cache.Word(12), 1u) << "version";
  EXPECT_EQ(cache.Word(16), static_cast<std::uint32_t>(scene.frames[0].vertex_count()));
  EXPECT_EQ(cache.Float(20), 0) << "first frame";
  EXPECT_EQ(cache.Float(24), 1) << "frames per sample";
  EXPECT_EQ(cache.Word(28), 11u) << "0 0 0 1 2 3 3 3 2 1 0";
  ExpectSamples(cache, 32, InFaceOrder(scene));
  EXPECT_GT(made.error_over_diagonal, 0) << "the frames have doubles";
  EXPECT_LT(made.error_over_diagonal, 1e-7);
}

TEST(MakePc2, FramesWithYUpKeepTheirAxes) {
  TestSceneOptions options;
  options.z_up = false;
  const Scene scene = TestScene(options);
  ExpectSamples({BytesOf(MakePc2(scene, nullptr), "cache/character.pc2"), false}, 32,
                InFaceOrder(scene));
}

TEST(MakeMdd, HoldsEveryShownFrameAndItsTimeInBigEndian) {
  TestSceneOptions options;
  options.bends = {0, 0, 2, 2, 5};
  options.stands = {1, 1, 1, 1, 0};
  options.playback = {12.5, 0, "none"};
  const Scene scene = TestScene(options);
  const FormatFiles made = MakeMdd(scene, nullptr);
  const Cache cache{BytesOf(made, "cache/character.mdd"), true};
  ASSERT_EQ(cache.Word(0), 5u);
  EXPECT_EQ(cache.Word(4), static_cast<std::uint32_t>(scene.frames[0].vertex_count()));
  for (int i = 0; i < 5; ++i) EXPECT_FLOAT_EQ(cache.Float(8 + 4 * i), i * 0.08f);
  ExpectSamples(cache, 8 + 4 * 5, InFaceOrder(scene));
  EXPECT_LT(made.error_over_diagonal, 1e-7);
}

TEST(MakePc2, TheMeshBesideTheCacheHasTheVerticesOfTheFirstSample) {
  const TestingFolder folder;
  WriteFiles(MakePc2(TestScene(), nullptr), TestScene(), folder.path());
  const Scene scene = InFaceOrder(TestScene());
  const Mesh mesh = ReadMesh(folder.path() / "cache/character.obj");
  EXPECT_EQ(mesh.faces, scene.frames[0].faces);
  const PointsX3 error = mesh.points - WithYUp(scene.frames[0].points, true);
  EXPECT_LT(error.cwiseAbs().maxCoeff(), 1e-6);
  ASSERT_TRUE(mesh.has_uvs());
  for (int f = 0; f < mesh.face_count(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::RowVector2d uv = scene.frames[0].uvs.row(scene.frames[0].uv_faces(f, k));
      ASSERT_LT((mesh.uvs.row(mesh.uv_faces(f, k)) - uv).norm(), 1e-6);
    }
  }
  const std::string material = ReadFile(folder.path() / "cache/character.mtl");
  EXPECT_THAT(material, ::testing::HasSubstr("map_Kd ../textures/texture_0.png\n"));
  Scene filmed = scene;
  filmed.frame_texture_names.assign(scene.frames.size(), "frame_0000.jpg");
  EXPECT_THAT(BytesOf(MakePc2(filmed, nullptr), "cache/character.mtl"),
              ::testing::HasSubstr("map_Kd ../textures/frame_0000.jpg\n"));
}

TEST(MakePc2, OneFrameWithoutTextureCoordinatesIsOneSample) {
  TestSceneOptions options;
  options.bends = {2};
  options.with_uvs = false;
  const Scene scene = TestScene(options);
  const FormatFiles made = MakePc2(scene, nullptr);
  EXPECT_EQ(Cache{BytesOf(made, "cache/character.pc2")}.Word(28), 1u);
  EXPECT_THAT(BytesOf(made, "cache/character.obj"), ::testing::Not(::testing::HasSubstr("vt ")));
  EXPECT_THAT(BytesOf(made, "cache/character.mtl"), ::testing::Not(::testing::HasSubstr("map_Kd")));
}

TEST(MakePc2, VerticesWithoutAFaceAreInNeitherMeshNorCache) {
  Scene scene = TestScene();
  const Scene without = scene;
  for (Mesh& frame : scene.frames) {  // a new vertex 5, which no face uses
    PointsX3 points(frame.points.rows() + 1, 3);
    points << frame.points.topRows(5), Eigen::RowVector3d(9, 9, 9),
        frame.points.bottomRows(frame.points.rows() - 5);
    frame.points = points;
    for (int& vertex : frame.faces.reshaped()) vertex += vertex >= 5;
  }
  scene.net = NetOf(scene.frames[0], {});
  const FormatFiles made = MakePc2(scene, nullptr), expected = MakePc2(without, nullptr);
  for (std::size_t i = 0; i < made.files.size(); ++i)
    EXPECT_EQ(made.files[i].bytes, expected.files[i].bytes) << made.files[i].path;
}

TEST(MakePc2, ANameWithBlanksIsOneWordInTheMesh) {
  Scene scene = TestScene();
  scene.name = "clay cat\nv 0 0 0";
  const FormatFiles made = MakePc2(scene, nullptr);
  EXPECT_THAT(made.files[0].bytes, ::testing::HasSubstr("\no clay_cat_v_0_0_0\n"));
}

TEST(MakePc2, TheMeshHasTheTemplatesPolygons) {
  const FormatFiles made = MakePc2(LanternScene(), nullptr);
  const NamedFaces given = FacesOfObj(LanternObj()), written = FacesOfObj(made.files[0].bytes);
  EXPECT_EQ(written.sizes, given.sizes);
  std::map<int, int> place;
  std::vector<int> renumbered;
  for (const int vertex : given.vertices)
    renumbered.push_back(place.emplace(vertex, SizeOf(place)).first->second);
  EXPECT_EQ(written.vertices, renumbered);
  EXPECT_THAT(written.uvs, ::testing::Pointwise(::testing::DoubleNear(1e-7), given.uvs));
}

class StopsAtOnce : public Progress {
 public:
  void Update(double, std::string_view) override {}
  bool cancelled() const override { return true; }
};

TEST(MakeMdd, StopsWhenAsked) {
  StopsAtOnce progress;
  EXPECT_THROW(MakeMdd(TestScene(), &progress), Cancelled);
}

class CacheInBlender : public ::testing::TestWithParam<std::tuple<const char*, const char*, bool>> {
};

TEST_P(CacheInBlender, EveryFrameIsInPlaceWithDefaultSettings) {
  if (!HasReader("blender")) GTEST_SKIP() << "Blender is not installed";
  const auto [extension, importer, z_up] = GetParam();
  TestSceneOptions options;
  options.bends = {0, 1, 2, 2, 2, 5};
  options.stands = {0, 0, 1, 1, 1, 0};
  options.playback = {24, 1, "pingpong"};
  options.z_up = z_up;
  const Scene scene = TestScene(options);
  const TestingFolder folder;
  const bool pc2 = std::string(extension) == "pc2";
  WriteFiles(pc2 ? MakePc2(scene, nullptr) : MakeMdd(scene, nullptr), scene, folder.path());
  WriteTruth(InFaceOrder(scene), folder.path() / "truth");
  const ReaderResult result =
      RunReader({"blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                 SourceFolder() + "/export/caches/testing/check_cache.py", "--",
                 folder.path() / "cache" / (std::string("character.") + extension),
                 folder.path() / "truth", importer});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(FigureOf(result.output, "frames"), ShownFrames(scene).size());
  EXPECT_GT(FigureOf(result.output, "moved_over_diagonal"), 0.1);
  EXPECT_LT(FigureOf(result.output, "error_over_diagonal"), 1e-6) << result.output;
  EXPECT_LT(FigureOf(result.output, "uv_error"), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Formats, CacheInBlender,
                         ::testing::Values(std::tuple("pc2", "new", true),
                                           std::tuple("mdd", "new", true),
                                           std::tuple("pc2", "legacy", false)));

}  // namespace keypose::exporting::caches_test
