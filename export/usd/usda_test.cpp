// USD files, read by their grammar and by three.js.
#include "export/usd/usda.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <sstream>

#include "core/numbers/parallel.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "export/caches/testing/polygon_scene.h"
#include "export/caches/testing/run_reader.h"
#include "export/caches/testing/test_scene.h"

namespace keypose::exporting::usda_test {

using ::testing::ElementsAreArray;
using ::testing::HasSubstr;
using ::testing::Pointwise;

std::string TextOf(const Scene& scene) { return MakeUsda(scene, nullptr).files.at(0).bytes; }

TEST(MakeUsda, OneFrameHasNoTimeSamples) {
  TestSceneOptions options;
  options.bends = {1};
  const std::string text = TextOf(TestScene(options));
  EXPECT_THAT(text, Not(HasSubstr("timeSamples")));
  EXPECT_THAT(text, HasSubstr("endTimeCode = 0\n"));
}

TEST(MakeUsda, AStepHasASampleAThousandthOfAFrameBefore) {
  TestSceneOptions options;
  options.bends = {0, 0, 3};
  options.stands = {1, 1, 0};
  options.playback = {30, 0, "none"};
  const std::string text = TextOf(TestScene(options));
  for (const char* time : {"\n            0: [", "\n            1.999: [", "\n            2: ["})
    EXPECT_THAT(text, HasSubstr(time));
}

TEST(MakeUsda, OfATextureForEachFrameTheFirstIsNamedAsItLies) {
  Scene scene = TestScene();
  EXPECT_THAT(TextOf(scene), HasSubstr("@textures/texture_0.png@"));
  scene.frame_texture_names.assign(scene.frames.size(), "frame_0000.jpg");
  EXPECT_THAT(TextOf(scene), HasSubstr("@textures/frame_0000.jpg@"));
}

TEST(MakeUsda, SameBytesForAnyThreadCount) {
  SetThreadCount(1);
  const std::string one = TextOf(TestScene());
  SetThreadCount(4);
  const std::string four = TextOf(TestScene());
  SetThreadCount(0);
  EXPECT_EQ(one, four);
}

class StopsAtOnce : public Progress {
 public:
  void Update(double, std::string_view) override {}
  bool cancelled() const override { return true; }
};

TEST(MakeUsda, StopsWhenAsked) {
  StopsAtOnce progress;
  EXPECT_THROW(MakeUsda(TestScene(), &progress), Cancelled);
}

ReaderResult Read(const Scene& scene) {
  const TestingFolder folder;
  WriteFiles(MakeUsda(scene, nullptr), scene, folder.path());
  WriteTruth(scene, folder.path() / "truth");
  return RunReader(
      {"node", SourceFolder() + "/export/usd/testing/read_usda.mjs", folder.path(), scene.name});
}

void ExpectRead(const ReaderResult& result) {
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const char* figure :
       {"error_over_diagonal", "extent_error_over_diagonal", "normal_error", "uv_error"})
    EXPECT_LT(FigureOf(result.output, figure), 1e-7) << figure;
  EXPECT_LT(FigureOf(result.output, "three_error_over_diagonal"), 1e-7);
  EXPECT_LT(FigureOf(result.output, "held_error_over_diagonal"), 1e-7);
}

TEST(MakeUsda, AnotherReaderFindsEveryFrameHoldAndStep) {
  TestSceneOptions options;
  options.bends = {0, 0, 2, 2, 5, 6, 7};
  options.stands = {1, 1, 1, 1, 0, 0, 0};
  options.playback = {23.976, 2, "pingpong"};
  const Scene scene = TestScene(options);
  const ReaderResult result = Read(scene);
  ExpectRead(result);
  EXPECT_GT(FigureOf(result.output, "moved_over_diagonal"), 0.1);
  EXPECT_EQ(FigureOf(result.output, "frames"), ShownFrames(scene).size());
  EXPECT_GT(FigureOf(result.output, "held_frames"), 5);
}

TEST(MakeUsda, AnotherReaderFindsFramesWithYUpAndAnOddName) {
  TestSceneOptions options;
  options.z_up = false;
  Scene scene = TestScene(options);
  scene.name = "9 'clay' cats";
  ExpectRead(Read(scene));
}

TEST(MakeUsda, AMeshWithoutTextureCoordinatesHasAPlainColour) {
  TestSceneOptions options;
  options.with_uvs = false;
  ExpectRead(Read(TestScene(options)));
}

/// The numbers of an attribute's value.
std::vector<double> NumbersOf(const std::string& text, const std::string& attribute) {
  const auto begin = text.find(attribute + " = [") + attribute.size() + 4;
  std::string list = text.substr(begin, text.find(']', begin) - begin);
  std::replace_if(
      list.begin(), list.end(), [](char c) { return c == ',' || c == '(' || c == ')'; }, ' ');
  std::istringstream words(list);
  return {std::istream_iterator<double>(words), {}};
}

TEST(MakeUsda, QuadsAndPolygonsComeOutAsTheyWentIn) {
  const std::string text = TextOf(LanternScene());
  const NamedFaces given = FacesOfObj(LanternObj());
  const auto counts = NumbersOf(text, "int[] faceVertexCounts");
  EXPECT_THAT(counts, ElementsAreArray(given.sizes));
  EXPECT_EQ(std::count(counts.begin(), counts.end(), 4), 18);
  EXPECT_THAT(NumbersOf(text, "int[] faceVertexIndices"), ElementsAreArray(given.vertices));
  const auto st = NumbersOf(text, "texCoord2f[] primvars:st");
  std::vector<double> corners;
  for (const double index : NumbersOf(text, "int[] primvars:st:indices"))
    corners.insert(corners.end(), {st[2 * static_cast<std::size_t>(index)],
                                   st[2 * static_cast<std::size_t>(index) + 1]});
  EXPECT_THAT(corners, Pointwise(::testing::DoubleNear(1e-7), given.uvs));
}

TEST(MakeUsda, VerticesWithoutAFaceHaveANormal) {
  Scene scene = TestScene();
  for (Mesh& frame : scene.frames) {
    frame.points.conservativeResize(frame.points.rows() + 1, 3);
    frame.points.bottomRows(1) << 0.5, 0.25, 2;
  }
  ExpectRead(Read(scene));
  EXPECT_THAT(TextOf(scene), HasSubstr(", (0, 1, -0)]"));
}

}  // namespace keypose::exporting::usda_test
