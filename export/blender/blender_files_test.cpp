// What the add-on reads, byte by byte; and what Blender shows after it read it.
#include "export/blender/blender_files.h"
#include "core/testing/paths.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/values/size_of.h"

namespace keypose::exporting::blender_files_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A limb along z, each face with its own patch of the texture.
Mesh Limb(int segments) {
  Mesh limb = MakeCylinder(0.12, 1, segments, 12);
  limb.uvs.resize(3 * limb.face_count(), 2);
  limb.uv_faces.resize(limb.face_count(), 3);
  for (int f = 0; f < limb.face_count(); ++f) {
    for (int k = 0; k < 3; ++k) {
      limb.uv_faces(f, k) = 3 * f + k;
      const Eigen::Vector3d point = limb.points.row(limb.faces(f, k));
      limb.uvs.row(3 * f + k) << 0.5 + 0.5 * point.x(), point.z();
    }
  }
  return limb;
}

/// The limb bent sideways round a circle's arc.
Mesh Bent(const Mesh& limb, double angle_deg) {
  Mesh bent = limb;
  const double angle = angle_deg * std::numbers::pi / 180;
  for (int v = 0; v < limb.vertex_count() && angle != 0; ++v) {
    const double turn = angle * limb.points(v, 2), radius = 1 / angle;
    const double reach = radius - limb.points(v, 0);
    bent.points(v, 0) = radius - reach * std::cos(turn);
    bent.points(v, 2) = reach * std::sin(turn);
  }
  return bent;
}

EncodedImage Plain(const fs::path& scratch, std::uint8_t red, std::uint8_t blue) {
  Image8 image(16, 16, 3);
  for (std::size_t i = 0; i < image.data.size(); i += 3) {
    image.data[i] = red;
    image.data[i + 2] = blue;
  }
  WriteImage(scratch / "plain.png", image);
  return {ReadFile(scratch / "plain.png"), "image/png", "plain"};
}

/// A hold of two frames, four frames that blend, two steps of two frames each, the end.
const std::vector<double> kAngles = {0, 0, 0, 30, 60, 90, 100, 100, 110, 110, 120};
const std::vector<char> kStands = {1, 1, 0, 0, 0, 0, 1, 1, 1, 1, 0};

Scene BendingScene(const Mesh& limb, double scale = 1) {
  Scene scene;
  std::vector<PointsX3> points;
  for (std::size_t i = 0; i < kAngles.size(); ++i) {
    scene.frames.push_back(Bent(limb, scale * kAngles[i]));
    scene.frame_names.push_back("frame_" + std::to_string(i));
    points.push_back(scene.frames[i].points);
    scene.texture_weights.push_back({1 - kAngles[i] / 120, kAngles[i] / 120});
  }
  scene.clip = MakeClip(points, kStands, false);
  scene.playback = {12, 0, "none"};
  scene.poses = {"rest", "bent"};
  scene.keys = {{0, "rest"}, {10, "bent"}};
  return scene;
}

Scene WithTextures(Scene scene, const fs::path& scratch, std::uint8_t shade) {
  scene.textures = {Plain(scratch, shade, 0), Plain(scratch, 0, shade)};
  return scene;
}

std::map<std::string, std::string> FilesOf(const Scene& scene) {
  std::map<std::string, std::string> files;
  for (const FormatFile& file : MakeBlenderFiles(scene, nullptr).files)
    files[file.path] = file.bytes;
  return files;
}

nlohmann::json JsonOf(const Scene& scene) {
  return nlohmann::json::parse(FilesOf(scene).at("blender/character.json"));
}

template <class Number>
Number At(const std::string& bytes, std::size_t at) {
  Number value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

TEST(MakeBlenderFiles, CacheHoldsEveryRunOfEqualFramesOnce) {
  const Scene scene = BendingScene(Limb(8));
  const std::string cache = FilesOf(scene).at("blender/character.pc2");
  const int vertex_count = scene.frames[0].vertex_count();
  EXPECT_EQ(cache.substr(0, 12), std::string("POINTCACHE2\0", 12));
  EXPECT_EQ(At<std::int32_t>(cache, 12), 1);
  EXPECT_EQ(At<std::int32_t>(cache, 16), vertex_count);
  EXPECT_EQ(At<std::int32_t>(cache, 28), 7);  // 0, 30, 60, 90, 100, 110, 120 degrees
  ASSERT_EQ(cache.size(), 32u + 12u * 7 * vertex_count);
  const Mesh third = Bent(Limb(8), 60);
  for (int v = 0; v < vertex_count; ++v)
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_EQ(At<float>(cache, 32 + 12 * (2 * vertex_count + v) + 4 * axis),
                static_cast<float>(third.points(v, axis)));
}

TEST(MakeBlenderFiles, YUpIsTurnedToBlendersZUp) {
  Scene scene = BendingScene(Limb(8));
  scene.z_up = false;
  const std::string cache = FilesOf(scene).at("blender/character.pc2");
  const Eigen::Vector3d point = scene.frames[0].points.row(5);
  EXPECT_EQ(At<float>(cache, 32 + 60), static_cast<float>(point.x()));
  EXPECT_EQ(At<float>(cache, 32 + 64), static_cast<float>(-point.z()));
  EXPECT_EQ(At<float>(cache, 32 + 68), static_cast<float>(point.y()));
}

TEST(MakeBlenderFiles, ErrorIsThatOfSinglePrecision) {
  const double error = MakeBlenderFiles(BendingScene(Limb(8)), nullptr).error_over_diagonal;
  EXPECT_GT(error, 0);
  EXPECT_LT(error, 1e-7);  // half a unit in the last place of numbers below 1
}

TEST(MakeBlenderFiles, CornersAndTextureCoordinatesAreThoseOfTheFirstFrame) {
  const Scene scene = BendingScene(Limb(8));
  const Mesh& mesh = scene.frames[0];
  const std::string bytes = FilesOf(scene).at("blender/character.bin");
  const std::size_t corners = 3 * mesh.face_count();
  ASSERT_EQ(bytes.size(), 12 * corners);
  for (std::size_t c = 0; c < corners; ++c) {
    const int f = static_cast<int>(c / 3), k = static_cast<int>(c % 3);
    EXPECT_EQ(At<std::int32_t>(bytes, 4 * c), mesh.faces(f, k));
    const int uv = mesh.uv_faces(f, k);
    EXPECT_EQ(At<float>(bytes, 4 * corners + 8 * c), static_cast<float>(mesh.uvs(uv, 0)));
    EXPECT_EQ(At<float>(bytes, 4 * corners + 8 * c + 4), static_cast<float>(mesh.uvs(uv, 1)));
  }
}

TEST(MakeBlenderFiles, MomentsSayWhichPictureShowsAndWhetherItStands) {
  const nlohmann::json told = JsonOf(BendingScene(Limb(8)));
  std::vector<int> pictures, stands;
  for (const auto& moment : told["moments"]) {
    pictures.push_back(moment["picture"]);
    stands.push_back(moment["stands"].get<bool>());
  }
  EXPECT_THAT(pictures, ElementsAre(0, 0, 0, 1, 2, 3, 4, 4, 5, 5, 6, 6));
  EXPECT_THAT(stands, ElementsAre(1, 1, 0, 0, 0, 0, 1, 1, 1, 1, 1, 0));
  EXPECT_EQ(told["shown_frames"], 11);
  EXPECT_EQ(told["keys"][1]["pose"], "bent");
  EXPECT_DOUBLE_EQ(told["keys"][1]["seconds"], 10 / 12.0);
}

TEST(MakeBlenderFiles, EqualShapesWithOtherTextureWeightsArePicturesOfTheirOwn) {
  Scene scene = BendingScene(Limb(8), 0);
  EXPECT_EQ(JsonOf(scene)["pictures"], 7);
  scene.texture_weights.clear();
  EXPECT_EQ(JsonOf(scene)["pictures"], 1);
}

TEST(MakeBlenderFiles, OneFrameWithoutTextureCoordinatesIsOnePicture) {
  Scene scene;
  scene.frames = {MakeIcosphere(1)};
  scene.frame_names = {"frame_0000"};
  scene.clip = MakeClip({scene.frames[0].points}, {}, false);
  const nlohmann::json told = JsonOf(scene);
  EXPECT_EQ(told["pictures"], 1);
  EXPECT_EQ(told["has_uvs"], false);
  EXPECT_EQ(told["textures"].size(), 0u);
  EXPECT_EQ(FilesOf(scene).at("blender/character.bin").size(), 12u * 80);
}

TEST(BlenderAddOn, SaysItsLicenceAndIsWrittenUnchanged) {
  const std::string source =
      ReadFile(fs::path(SourceFolder()) / "export/blender/keypose_import.py");
  EXPECT_EQ(BlenderAddOn(), source);
  EXPECT_THAT(source, HasSubstr("SPDX-License-Identifier: AGPL-3.0-or-later"));
}

/// A project after `keypose run`, with its frames as PLY beside it.
void WriteProject(const Scene& scene, const fs::path& folder) {
  const fs::path animation = folder / "out/animation";
  for (const std::string below : {"textures", "blender", "ply"})
    fs::create_directories(animation / below);
  WriteFile(folder / "pipeline.yaml", "poses: {rest: photos/rest, bent: photos/bent}\n");
  WriteFile(animation / "animation.json", "{\"schema\": 1}\n");
  for (const auto& [path, bytes] : FilesOf(scene)) WriteFile(animation / path, bytes);
  for (int i = 0; i < SizeOf(scene.textures); ++i)
    WriteFile(animation / "textures" / scene.textures[i].FileName(i), scene.textures[i].bytes);
  int shown = 0;
  for (const int frame : ShownFrames(scene))
    WriteMesh(animation / "ply" / ("shown_" + std::to_string(1000 + shown++) + ".ply"),
              scene.frames[frame]);
}

TEST(BlenderAddOn, ImportsAndUpdatesInBlender) {
  if (std::system("blender --version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "no Blender: run ./dev setup";
  const TestingFolder own;
  const fs::path folder = own.path();
  const Scene scene = WithTextures(BendingScene(Limb(16)), folder, 200);
  WriteProject(scene, folder / "first");
  WriteProject(WithTextures(BendingScene(Limb(16), 0.5), folder, 100), folder / "second");
  Scene longer = WithTextures(BendingScene(Limb(20)), folder, 200);
  longer.playback = {12, 2, "pingpong"};
  WriteProject(longer, folder / "other_faces");
  Scene lying = scene;
  lying.z_up = false;
  WriteProject(lying, folder / "y_up");
  const std::string command = "BLENDER_USER_SCRIPTS=" + (folder / "scripts").string() +
                              " blender -b --factory-startup --python-exit-code 1 --python " +
                              SourceFolder() + "/export/blender/testing/add_on_test.py -- " +
                              folder.string() + " > " + (folder / "log").string() + " 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << ReadFile(folder / "log");
  EXPECT_THAT(ReadFile(folder / "log"), HasSubstr("add_on_test: passed"));
}

}  // namespace keypose::exporting::blender_files_test
