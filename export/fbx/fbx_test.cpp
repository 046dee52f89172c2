// What the FBX file of a scene holds, and how its error is measured.
#include "export/fbx/fbx.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "export/caches/testing/test_scene.h"
#include "export/fbx/fbx_records.h"

namespace keypose::exporting::fbx_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string BytesOf(const Scene& scene) { return MakeFbx(scene, nullptr).files.at(0).bytes; }

/// The objects of a file, in order, by type and class: "Geometry Shape".
std::multimap<std::string, FbxRecord> ObjectsOf(const std::string& bytes) {
  std::multimap<std::string, FbxRecord> objects;
  for (const FbxRecord& section : ReadFbx(bytes)) {
    if (section.name != "Objects") continue;
    for (const FbxRecord& object : section.records)
      objects.emplace(object.name + " " + object.values[2].AsText(), object);
  }
  return objects;
}

const FbxRecord& Only(const std::multimap<std::string, FbxRecord>& objects,
                      const std::string& kind) {
  EXPECT_EQ(objects.count(kind), 1u) << kind;
  return objects.find(kind)->second;
}

std::vector<std::string> NamesOf(const std::multimap<std::string, FbxRecord>& objects,
                                 const std::string& kind) {
  std::vector<std::string> names;
  const auto [begin, end] = objects.equal_range(kind);
  for (auto object = begin; object != end; ++object)
    names.emplace_back(object->second.values[1].AsText().c_str());  // up to the class
  return names;
}

/// A property of the scene's settings, as stored.
FbxValue Setting(const std::string& bytes, const std::string& name) {
  for (const FbxRecord& section : ReadFbx(bytes)) {
    if (section.name != "GlobalSettings") continue;
    for (const FbxRecord& property : section.Inner("Properties70").records)
      if (property.values[0].AsText() == name) return property.values.at(4);
  }
  throw std::runtime_error("no setting " + name);
}

TEST(MakeFbx, ErrorIsThatOfSinglePrecision) {
  TestSceneOptions options;
  options.playback = {24, 2, "pingpong"};
  const FormatFiles made = MakeFbx(TestScene(options), nullptr);
  EXPECT_GT(made.error_over_diagonal, 0);
  EXPECT_LT(made.error_over_diagonal, 1e-7);
  EXPECT_EQ(made.measured.at("shapes"), 3);
  EXPECT_EQ(made.files.at(0).path, "character.fbx");
}

TEST(MakeFbx, EachPictureIsOneShapeNamedAfterItsFirstFrame) {
  TestSceneOptions options;
  options.bends = {0, 0, 2, 2, 4, 0, 4};
  const auto objects = ObjectsOf(BytesOf(TestScene(options)));
  EXPECT_THAT(NamesOf(objects, "Geometry Shape"), ElementsAre("frame_0002", "frame_0004"));
  EXPECT_THAT(NamesOf(objects, "Deformer BlendShapeChannel"),
              ElementsAre("frame_0002", "frame_0004"));
  EXPECT_EQ(objects.count("AnimationCurve "), 2u);
}

TEST(MakeFbx, ShapeHasOnlyVerticesThatMoveOrTurn) {
  Scene scene = TestScene();
  for (Mesh& frame : scene.frames) frame.points = scene.frames[0].points;
  scene.frames[3].points.row(40) += Eigen::RowVector3d(0.25, 0.125, 0.125);
  scene.split = MakeAnimatedMesh(scene.frames, scene.frame_names);
  scene.clip = MakeClip(scene.split.points, {}, false);
  const auto objects = ObjectsOf(BytesOf(scene));
  const FbxRecord& shape = Only(objects, "Geometry Shape");
  const auto vertices = shape.Inner("Indexes").values[0].AsIntegers();
  EXPECT_EQ(vertices.size(), 7u) << "the vertex and its six neighbours, whose normals turn";
  const auto moves = shape.Inner("Vertices").values[0].AsDoubles();
  ASSERT_EQ(moves.size(), 21u);
  double length = 0;
  for (const double move : moves) length += std::abs(move);
  EXPECT_EQ(length, 0.5);
  EXPECT_EQ(shape.Inner("Normals").values[0].AsDoubles().size(), 21u);
}

TEST(MakeFbx, PictureThatDiffersByLessThanSinglePrecisionIsAShapeThatMovesNothing) {
  Scene scene = TestScene();
  for (Mesh& frame : scene.frames) frame.points = scene.frames[0].points;
  scene.frames[3].points(0, 0) = std::nextafter(scene.frames[3].points(0, 0), 9);
  scene.split = MakeAnimatedMesh(scene.frames, scene.frame_names);
  scene.clip = MakeClip(scene.split.points, {}, false);
  const auto objects = ObjectsOf(BytesOf(scene));
  EXPECT_GE(Only(objects, "Geometry Shape").Inner("Indexes").values[0].AsIntegers().size(), 1u);
}

TEST(MakeFbx, TextureCoordinatesAreNotSplitAndTheImageIsInside) {
  const Scene scene = TestScene();
  const auto objects = ObjectsOf(BytesOf(scene));
  const FbxRecord& mesh = Only(objects, "Geometry Mesh");
  EXPECT_EQ(mesh.Inner("Vertices").values[0].AsDoubles().size(),
            3u * scene.frames[0].vertex_count());
  const FbxRecord& uvs = mesh.Inner("LayerElementUV");
  EXPECT_EQ(uvs.Inner("UV").values[0].AsDoubles().size(), 2u * scene.frames[0].uvs.rows());
  EXPECT_EQ(uvs.Inner("UVIndex").values[0].AsIntegers().size(), 3u * scene.frames[0].face_count());
  const FbxRecord& video = Only(objects, "Video Clip");
  EXPECT_EQ(video.Inner("Content").values[0].AsText(), scene.textures[0].bytes);
  EXPECT_EQ(video.Inner("RelativeFilename").values[0].AsText(), "textures/texture_0.png");
  Scene filmed = scene;
  filmed.frame_texture_names.assign(scene.frames.size(), "frame_0000.jpg");
  const FbxRecord other = Only(ObjectsOf(BytesOf(filmed)), "Video Clip");
  EXPECT_EQ(other.Inner("RelativeFilename").values[0].AsText(), "textures/frame_0000.jpg");
}

TEST(MakeFbx, OneFrameWithoutTextureHasNoShapesAndNoAnimation) {
  TestSceneOptions options;
  options.bends = {2};
  options.with_uvs = false;
  const auto objects = ObjectsOf(BytesOf(TestScene(options)));
  EXPECT_EQ(objects.size(), 3u) << "geometry, model, material";
  EXPECT_EQ(objects.count("Geometry Mesh"), 1u);
}

TEST(MakeFbx, FrameRateIsAModeOfTheFormatOrACustomRate) {
  const std::vector<std::pair<double, int>> modes{
      {24, 11}, {25, 10}, {30, 6}, {60, 3}, {24 / 1.001, 13}, {12.5, 14}, {23.976, 14}, {1000, 14}};
  for (const auto& [fps, mode] : modes) {
    TestSceneOptions options;
    options.playback.fps = fps;
    const std::string bytes = BytesOf(TestScene(options));
    EXPECT_EQ(Setting(bytes, "TimeMode").AsInteger(), mode) << fps;
    EXPECT_EQ(Setting(bytes, "CustomFrameRate").stored(), FbxValue(mode == 14 ? fps : -1).stored());
    EXPECT_EQ(Setting(bytes, "TimeSpanStop").AsInteger(), std::llround(3 * 46186158000 / fps));
  }
}

TEST(MakeFbx, CurvesHaveKeysOnlyWhereTheirShapeComesAndGoes) {
  TestSceneOptions options;
  options.bends = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  options.playback.fps = 24;
  const FormatFiles made = MakeFbx(TestScene(options), nullptr);
  // Three keys each, and one at either end unless it is already there.
  EXPECT_EQ(made.measured.at("keys"), 9 * 5 - 4);
}

TEST(MakeFbx, SameBitsForAnyThreadCount) {
  const Scene scene = TestScene();
  SetThreadCount(1);
  const std::string one = BytesOf(scene);
  SetThreadCount(5);
  const std::string five = BytesOf(scene);
  SetThreadCount(0);
  EXPECT_EQ(one, five);
}

TEST(MakeFbx, NoFramesThrowInputError) { EXPECT_THROW(MakeFbx(Scene(), nullptr), InputError); }

TEST(MakeFbx, TextureWithoutTextureCoordinatesThrowsInputErrorThatNamesIt) {
  TestSceneOptions options;
  options.with_uvs = false;
  Scene scene = TestScene(options);
  scene.textures = {{"bytes", "image/png", "clay"}};
  try {
    MakeFbx(scene, nullptr);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("texture clay cannot be used"));
  }
}

class StopsAtOnce : public Progress {
 public:
  void Update(double, std::string_view) override {}
  bool cancelled() const override { return true; }
};

TEST(MakeFbx, StopsWhenAsked) {
  StopsAtOnce progress;
  EXPECT_THROW(MakeFbx(TestScene(), &progress), Cancelled);
}

}  // namespace keypose::exporting::fbx_test
