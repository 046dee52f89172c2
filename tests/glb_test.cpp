// The exported file in other programs: the Khronos validator and Blender.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "tests/run_program.h"
#include "views/decode/read_sound.h"
#include "views/film/mp4.h"

namespace keypose::tests::glb_test {

namespace fs = std::filesystem;
constexpr int kFrames = 6;

// A tube with texture coordinates that bends from frame to frame.
Mesh UnwrappedTube() {
  Mesh mesh = MakeCylinder(1, 4, 24, 12);
  mesh.uv_faces = mesh.faces;
  mesh.uvs.resize(mesh.vertex_count(), 2);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    mesh.uvs.row(v) << 0.5 + 0.4 * mesh.points(v, 0), 0.5 + 0.1 * mesh.points(v, 2);
  }
  return mesh;
}

class ExportedGlb : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(frames_);
    Mesh mesh = UnwrappedTube();
    vertices_ = mesh.vertex_count();
    for (int i = 0; i < kFrames; ++i) {
      Mesh frame = mesh;
      for (int v = 0; v < frame.vertex_count(); ++v)
        frame.points(v, 0) += 0.05 * i * std::pow(frame.points(v, 2), 2);
      WriteMesh(frames_ / ("frame_000" + std::to_string(i) + ".ply"), frame);
    }
    Image8 texture(64, 32, 3);
    for (int y = 0; y < texture.height; ++y) {
      for (int x = 0; x < texture.width; ++x)
        texture.at(x, y)[0] = static_cast<std::uint8_t>(4 * x), texture.at(x, y)[1] = 120;
    }
    WriteImage(texture_, texture);
  }

  /// With a small film: drawing a large one takes most of the time.
  RunResult Export(const std::vector<std::string>& more = {}) {
    std::vector<std::string> command{"keypose-export", "--frames",       frames_, "--animation",
                                     animation_,       "--video_height", "108"};
    if (std::find(more.begin(), more.end(), "--video_width") == more.end())
      command.insert(command.end(), {"--video_width", "192"});
    command.insert(command.end(), more.begin(), more.end());
    return RunProgram(command, folder_.path());
  }
  std::string Glb() const { return animation_ / "character.glb"; }
  std::string FullGlb() const { return animation_ / "character_full.glb"; }

  RunResult Validate(const std::string& glb) {
    return RunProgram({"node", SourceFolder() + "/tests/validate_gltf.mjs", glb}, folder_.path());
  }
  RunResult ImportInBlender(const std::string& glb, int shape_keys, int vertices,
                            int texture_width) {
    return RunProgram(
        {"blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
         SourceFolder() + "/tests/check_blender.py", "--", glb, std::to_string(shape_keys),
         std::to_string(vertices), std::to_string(texture_width)},
        folder_.path());
  }

  TestingFolder folder_;
  fs::path frames_ = folder_.path() / "frames", animation_ = folder_.path() / "animation",
           texture_ = folder_.path() / "clay.png";
  int vertices_ = 0;
};

class ExportedGlbOnTwos : public ExportedGlb {
 protected:
  void SetUp() override {
    ExportedGlb::SetUp();
    // 0 0 2 2 4 0: on twos from one key to the next, which shows the first picture again.
    for (const auto& [frame, as] : {std::pair(1, 0), std::pair(3, 2), std::pair(5, 0)})
      fs::copy_file(frames_ / ("frame_000" + std::to_string(as) + ".ply"),
                    frames_ / ("frame_000" + std::to_string(frame) + ".ply"),
                    fs::copy_options::overwrite_existing);
    WriteDistortion({0, 0, 0.4, 0.4, 0.8, 1}, {true, true, true, true, true, false});
    Image8 other(64, 32, 3);
    WriteImage(other_texture_, other);
  }
  void WriteDistortion(const std::vector<double>& t, const std::vector<bool>& stands) {
    std::string text;
    for (std::size_t i = 0; i < t.size(); ++i)
      text += std::string(i ? ", " : "") + R"({"t": )" + std::to_string(t[i]) + R"(, "stands": )" +
              (stands[i] ? "true" : "false") + "}";
    WriteFile(frames_ / "distortion.json",
              R"({"schema": 2, "loop": false, "key_frames": [0, 5], "frames": [)" + text + "]}");
  }
  std::vector<std::string> BothTextures() const {
    return {"--textures", texture_, "--textures", other_texture_, "--poses", "rest,bent"};
  }
  fs::path other_texture_ = folder_.path() / "bent.png";
};

bool HasValidator() {
  return HasProgram("node") && fs::exists(SourceFolder() + "/node_modules/gltf-validator");
}

TEST_F(ExportedGlb, IsTurnedSoThatTheFrontLooksToTheFilm) {
  const auto points = [&] { return ReadMesh(animation_ / "obj/frame_0005.obj").points; };
  ASSERT_EQ(Export({"--formats", "obj"}).exit_code, 0);
  const PointsX3 plain = points();
  // The tube bends to +x, which is 90 degrees from -y.
  ASSERT_EQ(Export({"--formats", "obj", "--front", "90"}).exit_code, 0);
  const PointsX3 turned = points();
  ASSERT_EQ(turned.rows(), plain.rows());
  // y is up in OBJ, and the film looks from z.
  EXPECT_LT((turned.col(2) - plain.col(0)).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_LT((turned.col(0) + plain.col(2)).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_EQ(turned.col(1), plain.col(1));
}

TEST_F(ExportedGlb, PlaysAtTheRateOfItsFramesUnlessAnotherIsGiven) {
  const auto has_rate = [&](const std::string& rate) {
    return ReadFile(animation_ / "animation.json").find("\"fps\": " + rate + ",") !=
           std::string::npos;
  };
  ASSERT_EQ(Export({"--formats", "glb"}).exit_code, 0);
  EXPECT_TRUE(has_rate("24.0")) << "nobody says";
  WriteFile(frames_ / "distortion.json", R"({"fps": 50, "frames": [{}, {}, {}, {}, {}, {}]})");
  ASSERT_EQ(Export({"--formats", "glb"}).exit_code, 0);
  EXPECT_TRUE(has_rate("50.0")) << "as filmed";
  ASSERT_EQ(Export({"--formats", "glb", "--fps", "12"}).exit_code, 0);
  EXPECT_TRUE(has_rate("12.0"));
  EXPECT_EQ(Export({"--formats", "glb", "--fps", "0.05"}).exit_code, 2);
}

TEST_F(ExportedGlb, PassesTheKhronosValidatorWithoutErrorsAndWarnings) {
  if (!HasValidator())
    GTEST_SKIP() << "node or node_modules/gltf-validator is missing: run ./dev setup";
  for (const auto& options : std::vector<std::vector<std::string>>{
           {"--textures", texture_}, {}, {"--hold", "3", "--loop", "pingpong"}}) {
    std::vector<std::string> both = options;
    both.insert(both.end(), {"--formats", "glb,glb-full"});
    const RunResult exported = Export(both);
    ASSERT_EQ(exported.exit_code, 0) << exported.output;
    for (const std::string& glb : {Glb(), FullGlb()}) {
      const RunResult validated = Validate(glb);
      EXPECT_EQ(validated.exit_code, 0) << validated.output;
      EXPECT_NE(validated.output.find("0 errors, 0 warnings"), std::string::npos)
          << validated.output;
    }
    fs::remove_all(animation_);
  }
}

TEST_F(ExportedGlb, ValidatorScriptFailsOnABrokenFile) {
  if (!HasValidator())
    GTEST_SKIP() << "node or node_modules/gltf-validator is missing: run ./dev setup";
  ASSERT_EQ(Export().exit_code, 0);
  fs::resize_file(Glb(), fs::file_size(Glb()) - 100);
  EXPECT_EQ(Validate(Glb()).exit_code, 1);
}

TEST_F(ExportedGlb, BlenderFindsShapeKeysActionAndTexture) {
  if (!HasProgram("blender")) GTEST_SKIP() << "blender is missing: run ./dev setup";
  const RunResult exported = Export({"--textures", texture_, "--formats", "glb,glb-full"});
  ASSERT_EQ(exported.exit_code, 0) << exported.output;
  const RunResult imported = ImportInBlender(FullGlb(), kFrames - 1, vertices_, 64);
  EXPECT_EQ(imported.exit_code, 0) << imported.output;
  const RunResult light = ImportInBlender(Glb(), 1, vertices_, 64);
  EXPECT_EQ(light.exit_code, 0) << light.output;
  const RunResult wrong = ImportInBlender(FullGlb(), kFrames, vertices_, 64);
  EXPECT_EQ(wrong.exit_code, 1) << "the check must fail on another number of shape keys\n"
                                << wrong.output;
}

TEST_F(ExportedGlb, TheLightOneHasFewTargetsASmallTextureAndSaysHowFarItIsOff) {
  Image8 large(300, 200, 3);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 300; ++x)
      for (int c = 0; c < 3; ++c)
        large.at(x, y)[c] = static_cast<std::uint8_t>(128 + 50 * std::sin(0.08 * x + c) +
                                                      50 * std::cos(0.07 * y) + (7 * x * y) % 5);
  WriteImage(texture_, large);
  const RunResult exported =
      Export({"--textures", texture_, "--formats", "glb,glb-full", "--glb_texture", "150"});
  ASSERT_EQ(exported.exit_code, 0) << exported.output;
  const auto formats = nlohmann::json::parse(ReadFile(animation_ / "animation.json"))["formats"];
  ASSERT_EQ(formats.size(), 2u);
  EXPECT_EQ(formats[0]["files"], nlohmann::json::array({"character.glb"}));
  EXPECT_EQ(formats[0]["morph_targets"], 1) << "one shape, more and more of it";
  EXPECT_LT(formats[0]["error_over_diagonal"], 1e-5);
  EXPECT_EQ(formats[0]["texture_width"], 150);
  EXPECT_EQ(formats[0]["texture_height"], 100);
  EXPECT_GT(formats[0]["texture_psnr_db"], 30);
  EXPECT_EQ(formats[1]["morph_targets"], kFrames - 1);
  const std::string light = ReadFile(Glb()), full = ReadFile(FullGlb());
  EXPECT_NE(light.find("image/jpeg"), std::string::npos);
  EXPECT_NE(full.find(ReadFile(texture_)), std::string::npos) << "as it is";
  EXPECT_LT(light.size(), full.size() / 2);
}

/// A WAV file of one channel, 8 bits: a square wave from `from_s` on, else silence.
std::string SquareWave(double from_s, double seconds) {
  constexpr int kRate = 8000;
  const auto word = [](std::uint32_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 255);
    return text;
  };
  std::string data;
  for (int i = 0; i < seconds * kRate; ++i)
    data += static_cast<char>(i < from_s * kRate ? 128 : i / 10 % 2 == 0 ? 200 : 56);
  const auto size = static_cast<std::uint32_t>(data.size());
  return "RIFF" + word(36 + size, 4) + "WAVEfmt " + word(16, 4) + word(1, 2) + word(1, 2) +
         word(kRate, 4) + word(kRate, 4) + word(1, 2) + word(8, 2) + "data" + word(size, 4) + data;
}

TEST_F(ExportedGlb, TheFilmCarriesItsSoundAndTheSheetShowsIt) {
  if (!CanWriteMp4()) GTEST_SKIP() << "libavcodec has no x264 here";
  WriteFile(folder_.path() / "line.wav", SquareWave(1.25, 3));
  const RunResult exported = Export({"--sound", folder_.path() / "line.wav", "--sound_at", "-1",
                                     "--formats", "video,sheet", "--fps", "4"});
  ASSERT_EQ(exported.exit_code, 0) << exported.output;
  const Sound heard = ReadSound(animation_ / "character.mp4");
  const double pictures = kFrames;
  EXPECT_NEAR(heard.seconds(), pictures / 4, 0.025);
  const auto loud = [&](double seconds) {
    return std::abs(heard.samples[2 * std::llround(seconds * kSoundRate)]);
  };
  double before = 0, after = 0;
  for (double t = 0.01; t < 0.23; t += 0.001) before = std::max<double>(before, loud(t));
  for (double t = 0.27; t < 1.4; t += 0.001) after += loud(t) / 1130;
  EXPECT_LT(before, 0.05) << "1.25 s of silence, of which 1 s is left out";
  EXPECT_NEAR(after, 72 / 128.0, 0.1);
  const std::string sheet = ReadFile(animation_ / "character_sheet.html");
  EXPECT_NE(sheet.find("sound until 2.00 s"), std::string::npos);
  EXPECT_FALSE(fs::exists(animation_ / "character.glb"));

  const RunResult late = Export({"--sound", folder_.path() / "line.wav", "--sound_at", "9",
                                 "--formats", "sheet", "--overwrite"});
  EXPECT_EQ(late.exit_code, 0) << late.output;
  EXPECT_NE(late.output.find("nothing of the sound is heard"), std::string::npos) << late.output;
  WriteFile(folder_.path() / "notes.wav", "shot on Monday");
  const RunResult none = Export({"--sound", folder_.path() / "notes.wav", "--overwrite"});
  EXPECT_EQ(none.exit_code, 3) << none.output;
}

TEST_F(ExportedGlb, OneMeshIsAGlbAndATurntable) {
  fs::rename(frames_ / "frame_0003.ply", folder_.path() / "figure.ply");
  frames_ = folder_.path() / "figure.ply";
  const RunResult exported = Export({"--textures", texture_, "--poses", "rest"});
  ASSERT_EQ(exported.exit_code, 0) << exported.output;
  EXPECT_TRUE(fs::exists(Glb()));
  EXPECT_GT(fs::file_size(animation_ / "character_turntable.mp4"), 1000u);
  EXPECT_FALSE(fs::exists(animation_ / "character.mp4"));
  const auto notes = nlohmann::json::parse(ReadFile(animation_ / "animation.json"));
  EXPECT_EQ(notes["keys"][0]["pose"], "rest");
  EXPECT_EQ(notes["formats"][0]["morph_targets"], 0);
}

TEST_F(ExportedGlbOnTwos, StepsAndTexturesOfTwoPosesPassTheKhronosValidator) {
  if (!HasValidator())
    GTEST_SKIP() << "node or node_modules/gltf-validator is missing: run ./dev setup";
  for (const bool all_steps : {true, false}) {
    if (!all_steps)
      WriteDistortion({0, 0, 0.4, 0.4, 0.8, 1}, {true, true, false, false, false, false});
    std::vector<std::string> options = BothTextures();
    options.insert(options.end(), {"--formats", "glb,glb-full"});
    const RunResult exported = Export(options);
    ASSERT_EQ(exported.exit_code, 0) << exported.output;
    for (const std::string& glb : {Glb(), FullGlb()}) {
      const RunResult validated = Validate(glb);
      EXPECT_NE(validated.output.find("0 errors, 0 warnings"), std::string::npos)
          << validated.output;
    }
    EXPECT_EQ(ReadFile(Glb()).find("\"keypose\""), std::string::npos)
        << "phones need no textures that they do not show";
    EXPECT_NE(ReadFile(FullGlb()).find("\"keypose\""), std::string::npos);
    fs::remove_all(animation_);
  }
}

TEST_F(ExportedGlbOnTwos, BlenderStepsToo) {
  if (!HasProgram("blender")) GTEST_SKIP() << "blender is missing: run ./dev setup";
  const auto steps_in_blender = [&](const std::string& expected) {
    return RunProgram({"blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                       SourceFolder() + "/tests/check_blender.py", "--", FullGlb(), "2",
                       std::to_string(vertices_), "64", expected},
                      folder_.path());
  };
  std::vector<std::string> options = BothTextures();
  options.insert(options.end(), {"--formats", "glb-full"});
  ASSERT_EQ(Export(options).exit_code, 0);
  const RunResult twos = steps_in_blender("11111");
  EXPECT_EQ(twos.exit_code, 0) << twos.output;
  fs::remove_all(animation_);
  WriteDistortion({0, 0, 0.4, 0.4, 0.8, 1}, {true, true, false, false, false, false});
  ASSERT_EQ(Export(options).exit_code, 0);
  const RunResult mixed = steps_in_blender("11100");
  EXPECT_EQ(mixed.exit_code, 0) << mixed.output;
  EXPECT_EQ(steps_in_blender("11111").exit_code, 1) << "the check must fail on a glide";
}

TEST_F(ExportedGlbOnTwos, TexturesThatAreNotOfTheKeysAreSaidAndTheFirstShows) {
  fs::remove(frames_ / "distortion.json");
  const RunResult exported = Export(BothTextures());
  EXPECT_EQ(exported.exit_code, 0) << exported.output;
  EXPECT_NE(exported.output.find("shows only the first texture"), std::string::npos)
      << exported.output;
}

TEST_F(ExportedGlbOnTwos, FilmLiesBesideTheGlb) {
  ASSERT_EQ(Export().exit_code, 0);
  EXPECT_GT(fs::file_size(animation_ / "character.mp4"), 1000u);
  fs::remove_all(animation_);
  ASSERT_EQ(Export({"--formats", "ply, glb"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(animation_ / "character.mp4"));
  EXPECT_FALSE(fs::exists(animation_ / "obj"));
  EXPECT_TRUE(fs::exists(animation_ / "ply" / "frame_0000.ply"));
  EXPECT_TRUE(fs::exists(animation_ / "character.glb"));
  fs::remove_all(animation_);
  const RunResult odd = Export({"--video_width", "321"});
  EXPECT_EQ(odd.exit_code, 2) << odd.output;
  const RunResult unknown = Export({"--formats", "glb,abc"});
  EXPECT_EQ(unknown.exit_code, 2) << unknown.output;
  EXPECT_NE(unknown.output.find("names 'abc'"), std::string::npos) << unknown.output;
  EXPECT_EQ(Export({"--formats", " ,"}).exit_code, 2);
}

TEST_F(ExportedGlb, SequencesHaveEveryFrameInOrderWithTheSamePositions) {
  const RunResult exported = Export({"--textures", texture_, "--formats", "obj,ply"});
  ASSERT_EQ(exported.exit_code, 0) << exported.output;
  for (int i = 0; i < kFrames; ++i) {
    const std::string name = "frame_000" + std::to_string(i);
    const Mesh frame = ReadMesh(frames_ / (name + ".ply"));
    for (const std::string kind : {"ply", "obj"}) {
      const Mesh written = ReadMesh(animation_ / kind / (name + "." + kind));
      EXPECT_TRUE(written.faces == frame.faces) << kind << " " << name;
      ASSERT_EQ(written.vertex_count(), frame.vertex_count());
      // OBJ files have y up, and their 17 digits are parsed with errors in the last bits.
      PointsX3 expected = frame.points;
      if (kind == "obj")
        expected.col(1) = frame.points.col(2), expected.col(2) = -frame.points.col(1);
      EXPECT_LE((written.points - expected).cwiseAbs().maxCoeff(), kind == "ply" ? 0 : 1e-14)
          << kind << " " << name;
      EXPECT_TRUE(written.has_uvs());
    }
  }
  EXPECT_TRUE(fs::exists(animation_ / "textures" / "texture_0.png"));
  EXPECT_TRUE(fs::exists(animation_ / "animation.json"));
}

TEST_F(ExportedGlb, ExportAgainGivesTheSameBytes) {
  ASSERT_EQ(Export({"--textures", texture_}).exit_code, 0);
  const auto size = fs::file_size(Glb());
  fs::rename(Glb(), folder_.path() / "first.glb");
  fs::remove_all(animation_);
  ASSERT_EQ(Export({"--textures", texture_}).exit_code, 0);
  EXPECT_EQ(fs::file_size(Glb()), size);
  EXPECT_EQ(
      RunProgram({"/usr/bin/cmp", Glb(), folder_.path() / "first.glb"}, folder_.path()).exit_code,
      0);
}

TEST_F(ExportedGlb, MissingFrameIsAnInputErrorThatNamesIt) {
  fs::remove(frames_ / "frame_0003.ply");
  const RunResult exported = Export();
  EXPECT_EQ(exported.exit_code, 3) << exported.output;
  EXPECT_NE(exported.output.find("frame 3 is missing"), std::string::npos) << exported.output;
  EXPECT_FALSE(fs::exists(animation_));
}

TEST_F(ExportedGlb, TextureThatIsNoImageIsAnInputErrorThatNamesIt) {
  const RunResult exported = Export({"--textures", frames_ / "frame_0000.ply"});
  EXPECT_EQ(exported.exit_code, 3) << exported.output;
  EXPECT_NE(exported.output.find("frame_0000.ply"), std::string::npos) << exported.output;
  EXPECT_FALSE(fs::exists(animation_));
}

TEST_F(ExportedGlb, FolderWithoutFramesIsAnInputError) {
  fs::remove_all(frames_);
  fs::create_directories(frames_);
  const RunResult exported = Export();
  EXPECT_EQ(exported.exit_code, 3) << exported.output;
  EXPECT_NE(exported.output.find("no frames"), std::string::npos) << exported.output;
}

}  // namespace keypose::tests::glb_test
