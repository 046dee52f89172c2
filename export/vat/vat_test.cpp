// Vertex animation textures, decoded by other programs: node with three.js, Chromium, and Khronos'
// validator.
#include "export/vat/vat.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "export/caches/testing/run_reader.h"
#include "export/caches/testing/test_scene.h"
#include "export/vat/vat_layout.h"

namespace keypose::exporting::vat_test {

const std::string kTools = SourceFolder() + "/export/vat/testing/";

const std::string& BytesOf(const FormatFiles& made, const std::string& path) {
  for (const FormatFile& file : made.files)
    if (file.path == path) return file.bytes;
  throw std::runtime_error("no file " + path);
}

TEST(MakeVat, ErrorIsBelowHalfAQuantum) {
  const FormatFiles made = MakeVat(TestScene(), nullptr);
  EXPECT_GT(made.error_over_diagonal, 0);
  // The bounds are rounded to single precision.
  EXPECT_LT(made.error_over_diagonal, made.measured.at("quantum_over_diagonal") + 2e-7);
  EXPECT_LT(made.measured.at("exr_error_over_diagonal"), 1e-7);
  EXPECT_LT(made.measured.at("normal_error_deg"), 0.4);
}

TEST(MakeVat, AMeshWithoutDepthHasNoErrorThere) {
  Scene scene = TestScene();
  for (PointsX3& points : scene.split.points) points.col(1).setConstant(0.25);
  const FormatFiles made = MakeVat(scene, nullptr);
  EXPECT_LT(made.error_over_diagonal, made.measured.at("quantum_over_diagonal") + 2e-7);
}

TEST(MakeVat, DescribesFramesAndKeys) {
  TestSceneOptions options;
  options.playback = {12, 2, "none"};
  Scene scene = TestScene(options);
  scene.name = "cat";
  scene.keys = {{0, "rest"}, {3, "bent"}};
  const auto json = nlohmann::json::parse(BytesOf(MakeVat(scene, nullptr), "vat/cat.json"));
  EXPECT_EQ(json["fps"], 12);
  EXPECT_EQ(json["frames"], 8) << "0 0 0 1 2 3 3 3";
  EXPECT_EQ(json["shown"][3], "frame_0001");
  EXPECT_EQ(json["keys"][1], (nlohmann::json{{"pose", "bent"}, {"frame", 5}}));
  EXPECT_EQ(json["loop"], false);
  EXPECT_EQ(json["mesh"], "cat.glb");
}

TEST(MakeVat, GodotKeepsPixelsAsNumbersByTheFilesBesideThem) {
  if (!HasReader("godot3-server")) GTEST_SKIP() << "godot3-server is missing: run ./dev setup";
  const TestingFolder folder;
  const Scene scene = TestScene();
  FormatFiles made = MakeVat(scene, nullptr);
  // After it has imported a mesh, this Godot does not end.
  std::erase_if(made.files, [](const FormatFile& file) { return file.path.ends_with(".glb"); });
  for (const FormatFile& file : made.files) {
    std::filesystem::create_directories((folder.path() / file.path).parent_path());
    WriteFile(folder.path() / file.path, file.bytes);
  }
  WriteFile(folder.path() / "project.godot", "config_version=4\n");
  WriteFile(folder.path() / "check.gd", R"(extends SceneTree
func _init():
	for kind in ["positions.exr", "normals.png"]:
		var texture = load("res://vat/character_" + kind)
		var image = texture.get_data()
		image.lock()
		var pixel = image.get_pixel(7, 2)
		var name = kind.split(".")[0]
		print(name, "_flags=", texture.flags, " ", name, "_mipmaps=", int(image.has_mipmaps()))
		print(name, "_r=", pixel.r, " ", name, "_g=", pixel.g, " ", name, "_b=", pixel.b)
	quit()
)");
  const std::string project = folder.path().string();
  RunReader({"env", "HOME=" + project, "godot3-server", "--path", project, "--editor", "--quit"},
            60);
  const ReaderResult read = RunReader(
      {"env", "HOME=" + project, "godot3-server", "--path", project, "-s", "check.gd"}, 60);
  for (const char* kind : {"positions", "normals"}) {
    EXPECT_EQ(FigureOf(read.output, kind + std::string("_flags")), 0) << read.output;
    EXPECT_EQ(FigureOf(read.output, kind + std::string("_mipmaps")), 0);
  }
  const int rows = MakeVatLayout(SizeOf(scene.split.source_vertex), 4).rows_per_frame;
  ASSERT_EQ(rows, 1) << "row 2 is frame 2";
  const Eigen::RowVector3d point = WithYUp(scene.split.points[2], true).row(7),
                           normal = WithYUp(scene.split.normals[2], true).row(7);
  const std::string axes[] = {"_r", "_g", "_b"};
  for (int c = 0; c < 3; ++c) {
    // Godot 3 cuts the numbers of an EXR off after 11 bits.
    EXPECT_NEAR(FigureOf(read.output, "positions" + axes[c]), point[c],
                std::abs(point[c]) / 1024 + 1e-6);
    EXPECT_NEAR(FigureOf(read.output, "normals" + axes[c]) * 2 - 1, normal[c], 1.0 / 255 + 1e-6);
  }
}

TEST(MakeVat, ALoopHasNoPictureTwiceAtItsSeam) {
  TestSceneOptions options;
  options.playback = {12, 0, "pingpong"};
  Scene scene = TestScene(options);
  scene.keys = {{0, "rest"}, {3, "bent"}};
  const auto back = nlohmann::json::parse(BytesOf(MakeVat(scene, nullptr), "vat/character.json"));
  EXPECT_EQ(back["loop"], true);
  EXPECT_EQ(back["frames"], 6) << "0 1 2 3 2 1, and 0 again";
  scene.playback.loop = "none";
  scene.clip.loop = true;
  const auto loop = nlohmann::json::parse(BytesOf(MakeVat(scene, nullptr), "vat/character.json"));
  EXPECT_EQ(loop["frames"], 3) << "0 1 2, and the last is the first";
  EXPECT_EQ(loop["keys"][1]["frame"], 0);
}

TEST(MakeVat, TheTimeOfDayIsInNoFile) {
  const FormatFiles made = MakeVat(TestScene(), nullptr);
  const std::string& exr = BytesOf(made, "vat/character_positions.exr");
  const std::string key("capDate\0string\0", 15);  // then the length of the text
  const auto at = exr.find(key);
  const std::string length = at == std::string::npos ? "" : exr.substr(at + key.size(), 4);
  EXPECT_THAT(length, ::testing::AnyOf("", std::string(4, '\0')));
  EXPECT_EQ(BytesOf(made, "vat/character_positions.png").find("tIME"), std::string::npos);
}

TEST(MakeVat, TextureWithoutCoordinatesThrowsInputError) {
  TestSceneOptions options;
  options.with_uvs = false;
  Scene scene = TestScene(options);
  EXPECT_NO_THROW(MakeVat(scene, nullptr));
  scene.textures = TestScene().textures;
  EXPECT_THROW(MakeVat(scene, nullptr), InputError);
}

class VatFiles : public ::testing::Test {
 protected:
  FormatFiles Write(const TestSceneOptions& options) {
    const Scene scene = TestScene(options);
    const FormatFiles made = MakeVat(scene, nullptr);
    WriteFiles(made, scene, folder_.path());
    WriteTruth(scene, folder_.path() / "truth");
    return made;
  }
  ReaderResult Decode() const {
    return RunReader({"node", kTools + "read_vat.mjs", folder_.path(), "character"});
  }
  ReaderResult RunInBrowser(const std::string& page) const {
    return RunReader({"node", kTools + "run_in_browser.mjs", folder_.path(), "character", page});
  }
  TestingFolder folder_;
};

void ExpectDecoded(const ReaderResult& result, const FormatFiles& made) {
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const double error = FigureOf(result.output, "error_over_diagonal");
  EXPECT_GT(FigureOf(result.output, "moved_over_diagonal"), 0.1);
  EXPECT_LT(error, made.measured.at("quantum_over_diagonal") + 2e-7);
  EXPECT_NEAR(error, made.error_over_diagonal, 1e-9);
  EXPECT_NEAR(FigureOf(result.output, "exr_error_over_diagonal"),
              made.measured.at("exr_error_over_diagonal"), 1e-9);
  EXPECT_NEAR(FigureOf(result.output, "normal_error_deg"), made.measured.at("normal_error_deg"),
              1e-4);
}

TEST_F(VatFiles, NodeDecodesEveryFrameFromPngAndThreeFromExr) {
  TestSceneOptions options;
  options.bends = {0, 0, 2, 2, 5};
  options.stands = {1, 1, 1, 1, 0};
  options.playback = {12, 1, "pingpong"};
  const FormatFiles made = Write(options);
  ExpectDecoded(Decode(), made);
}

TEST_F(VatFiles, NodeDecodesRowsThatWrap) {
  TestSceneOptions options;
  options.bends = {0, 3};
  options.segments = 160;
  options.rings = 110;
  options.z_up = false;
  const FormatFiles made = Write(options);
  const ReaderResult result = Decode();
  ExpectDecoded(result, made);
  EXPECT_EQ(FigureOf(result.output, "rows_per_frame"), 3);
}

TEST_F(VatFiles, TheValidatorFindsNothingWrongWithTheMesh) {
  for (const bool with_uvs : {true, false}) {
    TestSceneOptions options;
    options.with_uvs = with_uvs;
    Write(options);
    const ReaderResult result = RunReader({"node", SourceFolder() + "/tests/validate_gltf.mjs",
                                           folder_.path() / "vat/character.glb"});
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_THAT(result.output, ::testing::HasSubstr("0 errors, 0 warnings"));
  }
}

TEST_F(VatFiles, TheDocumentedThreeCodeDrawsEveryFrameInABrowser) {
  if (!HasReader("chromium")) GTEST_SKIP() << "Chromium is not installed";
  TestSceneOptions options;
  options.bends = {0, 2, 2, 6};
  options.segments = 48;
  options.rings = 180;  // more than one row per frame
  Write(options);
  const ReaderResult result = RunInBrowser("draw_page.mjs");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_GT(FigureOf(result.output, "covers"), 0.05);
  EXPECT_GT(FigureOf(result.output, "moves"), 0.02);
  EXPECT_LT(FigureOf(result.output, "differs"), 0.001) << result.output;
}

// Not the engines themselves, but their code with its own arithmetic, translated word by word to
// GLSL, on textures with the rows in the engines' order.
TEST_F(VatFiles, TheDocumentedShadersOfGodotAndUnityGiveEveryVertex) {
  if (!HasReader("chromium")) GTEST_SKIP() << "Chromium is not installed";
  TestSceneOptions options;
  options.bends = {0, 2, 2, 6};
  options.segments = 48;
  options.rings = 180;
  const FormatFiles made = Write(options);
  const ReaderResult result = RunInBrowser("engines_page.mjs");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_GT(FigureOf(result.output, "vertices"), kMostVatColumns) << "more than one row per frame";
  EXPECT_LT(FigureOf(result.output, "godot_error_over_diagonal"), 1e-6) << result.output;
  EXPECT_NEAR(FigureOf(result.output, "unity_error_over_diagonal"), made.error_over_diagonal, 1e-7);
  EXPECT_LT(FigureOf(result.output, "godot_normal_error"), 0.008);
  EXPECT_LT(FigureOf(result.output, "unity_normal_error"), 0.008);
}

}  // namespace keypose::exporting::vat_test
