#include <gtest/gtest.h>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/project/poses_io.h"
#include "core/io/project/timeline_json.h"
#include "core/io/testing/damaged_file.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::landmarks_io_test {

namespace fs = std::filesystem;

class LandmarksIo : public ::testing::Test, public TestingFolder {};

TEST_F(LandmarksIo, PicksComeBackAndKnowTheirMesh) {
  const Mesh mesh = MakeIcosphere(1);
  WriteLandmarks(folder_ / "l.json", mesh, {{"nose", 3, {0.2, 0.3, 0.5}}});
  const auto read = ReadLandmarks(folder_ / "l.json", mesh);
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].name, "nose");
  EXPECT_EQ(read[0].face, 3);
  EXPECT_THROW(ReadLandmarks(folder_ / "l.json", MakeBox(1, 1, 1)), InputError);
}

/// The text of a schema 1 file, as older versions wrote it.
std::string OldPicks(const Mesh& mesh) {
  return R"({"schema":1,"mesh":{"vertices":)" + std::to_string(mesh.vertex_count()) +
         R"(,"faces":)" + std::to_string(mesh.face_count()) +
         R"(},"landmarks":[{"name":"nose","face":3,"barycentric":[0.2,0.3,0.5]}]})";
}

TEST_F(LandmarksIo, OlderFilesAreBelievedWithAWarningWhereTheCountsAreTheSame) {
  const Mesh mesh = MakeIcosphere(1);
  CarryLog log;
  EXPECT_EQ(ReadLandmarks(Put("old.json", OldPicks(mesh)), mesh, &log)[0].face, 3);
  ASSERT_EQ(log.warnings.size(), 1u);
  EXPECT_NE(log.warnings[0].find("landmarks bind"), std::string::npos) << log.warnings[0];
  EXPECT_TRUE(log.unbound);
  EXPECT_THROW(ReadLandmarks(folder_ / "old.json", MakeIcosphere(2)), InputError);
}

TEST_F(LandmarksIo, PointsThatHangBesideTheMeshWerePickedOnAnother) {
  const Mesh mesh = MakeIcosphere(4);
  const auto put = [&](double radius) {
    std::string text = "<PickedPoints>\n";
    for (const char* axis : {"x", "y", "z"})
      for (const double side : {-radius, radius})
        text += "<point " + std::string(axis == std::string("x") ? "" : "x=\"0\" ") +
                (axis == std::string("y") ? "" : "y=\"0\" ") +
                (axis == std::string("z") ? "" : "z=\"0\" ") + axis + "=\"" + std::to_string(side) +
                "\" name=\"" + axis + std::to_string(side) + "\"/>\n";
    return Put("p.pp", text + "</PickedPoints>\n");
  };
  CarryLog log;
  EXPECT_EQ(ReadPicks(put(1.0), mesh, &log).size(), 6u);
  EXPECT_TRUE(log.warnings.empty()) << log.warnings[0];
  EXPECT_EQ(ReadPicks(put(1.01), mesh, &log).size(), 6u);  // 0.3 % of the diagonal
  EXPECT_EQ(log.warnings.size(), 1u);
  EXPECT_THROW(ReadPicks(put(1.03), mesh, &log), InputError);  // 0.9 %
}

TEST_F(LandmarksIo, FaceBeyondTheMeshIsNamed) {
  Put("l.json",
      R"({"schema":1,"landmarks":[{"name":"left-eye","face":9001,"barycentric":[1,0,0]}]})");
  try {
    ReadLandmarks(folder_ / "l.json", MakeIcosphere(1));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(
        std::string(error.what()).find("'left-eye' is on face 9001, but the mesh has 80 faces"),
        std::string::npos)
        << error.what();
  }
}

TEST_F(LandmarksIo, TextPairsGiveTheVertices) {
  const Mesh mesh = MakeIcosphere(1);
  const auto pairs = ReadLandmarkPairs({Put("p.txt", "# two pairs\n3 5\n7 9\n")}, mesh, mesh);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_LT((PositionOf(pairs[0].source, mesh) - mesh.points.row(3).transpose()).norm(), 1e-15);
  EXPECT_LT((PositionOf(pairs[1].target, mesh) - mesh.points.row(9).transpose()).norm(), 1e-15);
  EXPECT_THROW(ReadLandmarkPairs({Put("q.txt", "3 5\n3 6\n")}, mesh, mesh), InputError);
  EXPECT_THROW(ReadLandmarkPairs({Put("r.txt", "3 500\n")}, mesh, mesh), InputError);
  EXPECT_THROW(ReadLandmarkPairs({Put("s.txt", "three 5\n")}, mesh, mesh), InputError);
}

TEST_F(LandmarksIo, PairsComeBackWithWhatAPersonSaidOfThem) {
  const Mesh source = MakeIcosphere(1), target = MakeIcosphere(2);
  LandmarkPair pair{"ear", {"ear", 3, {0.25, 0.25, 0.5}}, {"ear", 300, {1, 0, 0}}, false, 0.5,
                    "tip"};
  WriteLandmarkPairs(folder_ / "pairs.json", source, target, {pair});
  const auto read = ReadLandmarkPairs({folder_ / "pairs.json"}, source, target);
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].name, "ear");
  EXPECT_EQ(read[0].target.face, 300);
  EXPECT_EQ(read[0].source.barycentric, pair.source.barycentric);
  EXPECT_FALSE(read[0].confirmed);
  EXPECT_EQ(read[0].confidence, 0.5);
  EXPECT_EQ(read[0].origin, "tip");
  EXPECT_THROW(ReadLandmarkPairs({folder_ / "pairs.json"}, MakeBox(1, 1, 3), target),
               InputError);  // of another shape
  EXPECT_THROW(
      ReadLandmarkPairs({Put("one.json", R"({"schema":1,"landmarks":[]})")}, source, target),
      InputError);
  EXPECT_THROW(
      ReadLandmarkPairs({Put("cut.json", R"({"schema":1,"pairs":[{"name":)")}, source, target),
      InputError);
  const std::string place = R"({"face":1,"barycentric":[1,0,0]})";
  const std::string entry = R"({"name":"a","source":)" + place + R"(,"target":)" + place + "}";
  EXPECT_TRUE(
      ReadLandmarkPairs({Put("hand.json", R"({"pairs":[)" + entry + "]}")}, source, target)[0]
          .confirmed);
  EXPECT_THROW(ReadLandmarkPairs({Put("twice.json", R"({"pairs":[)" + entry + "," + entry + "]}")},
                                 source, target),
               InputError);
}

TEST_F(LandmarksIo, MeshLabPicksSnapToTheSurfaceAndJoinByName) {
  const Mesh mesh = MakeIcosphere(2);
  const auto pp = [&](const char* file, double x) {
    return Put(file, "<!DOCTYPE PickedPoints>\n<PickedPoints>\n<point x=\"" + std::to_string(x) +
                         "\" y=\"0\" z=\"0\" name=\"tip\" active=\"1\"/>\n</PickedPoints>\n");
  };
  const auto pairs = ReadLandmarkPairs({pp("a.pp", 1.0), pp("b.pp", -1.0)}, mesh, mesh);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_GT(PositionOf(pairs[0].source, mesh).x(), 0.95);
  EXPECT_LT(PositionOf(pairs[0].target, mesh).x(), -0.95);
  EXPECT_THROW(ReadLandmarkPairs({pp("a.pp", 1.0), pp("c.pp", 9.0)}, mesh, mesh), InputError);
}

/// Picks in the middle of faces, by names that XML and JSON must escape.
std::vector<Landmark> OddlyNamedPicks() {
  return {{"a < b & \"c\"", 3, {0.2, 0.3, 0.5}},
          {"it's", 40, {0.6, 0.25, 0.15}},
          {"n\u00e4se>", 79, {0.125, 0.5, 0.375}}};
}

void ExpectSamePicks(const std::vector<Landmark>& read, const std::vector<Landmark>& picks) {
  ASSERT_EQ(read.size(), picks.size());
  for (const Landmark& pick : picks) {
    const auto same = std::find_if(read.begin(), read.end(),
                                   [&](const Landmark& one) { return one.name == pick.name; });
    ASSERT_NE(same, read.end()) << pick.name;
    EXPECT_EQ(same->face, pick.face) << pick.name;
    EXPECT_LT((same->barycentric - pick.barycentric).norm(), 1e-12) << pick.name;
  }
}

TEST_F(LandmarksIo, PicksComeBackFromMeshLabsPoints) {
  const Mesh mesh = MakeIcosphere(1);
  CarryLog log;
  const fs::path file = Put("p.pp", PickedPointsText(OddlyNamedPicks(), mesh));
  ExpectSamePicks(ReadPicks(file, mesh, &log), OddlyNamedPicks());
  EXPECT_TRUE(log.warnings.empty()) << log.warnings[0];
}

TEST_F(LandmarksIo, PicksComeBackFromWrapsPoints) {
  const Mesh mesh = MakeIcosphere(1);
  CarryLog log;
  const fs::path file = Put("wrap.json", WrapPointsText(OddlyNamedPicks()));
  ExpectSamePicks(ReadPicks(file, mesh, &log, "scan"), OddlyNamedPicks());
  EXPECT_TRUE(log.unbound);
  ASSERT_EQ(log.warnings.size(), 1u);
  EXPECT_NE(log.warnings[0].find("if the scan was rebuilt"), std::string::npos) << log.warnings[0];
}

TEST_F(LandmarksIo, WrapsPointsWithoutNamesAreNumbered) {
  const Mesh mesh = MakeIcosphere(1);
  const fs::path file = Put("list.json", " [[3, 0.2, 0.3], [40, 1, 0]]");
  ExpectSamePicks(ReadPicks(file, mesh), {{"1", 3, {0.2, 0.3, 0.5}}, {"2", 40, {1, 0, 0}}});
  const auto pairs = ReadLandmarkPairs({file, file}, mesh, mesh);
  ASSERT_EQ(pairs.size(), 2u);
  const Eigen::Vector3d corner = mesh.points.row(mesh.faces(40, 0));
  EXPECT_LT((PositionOf(pairs[1].target, mesh) - corner).norm(), 1e-12);
}

TEST_F(LandmarksIo, WrapsPointsOfAnotherMeshAreInputErrors) {
  const Mesh mesh = MakeIcosphere(1);
  for (const char* text :
       {R"({"nose": [80, 0.2, 0.3]})", R"({"nose": [-1, 0.2, 0.3]})", R"({"nose": [1e300, 0, 1]})",
        R"({"nose": [3.5, 0.2, 0.3]})", R"({"nose": [3, 0.7, 0.7]})",
        R"({"nose": [3, 0.2, 0.3], "ear": [3, 0.2]})", R"([[3, 0.2, 0.3], {"face": 3}])"})
    EXPECT_THROW(ReadPicks(Put("w.json", text), mesh), InputError) << text;
  const fs::path one = Put("w.json", R"({"nose": [3, 0.2, 0.3]})");
  EXPECT_THROW(ReadLandmarkPairs({one}, mesh, mesh), InputError);
}

using HostilePicks = HostileFile;

TEST_F(HostilePicks, XmlWithoutItsRootOrWithoutEndIsAnInputError) {
  const Mesh mesh = MakeIcosphere(1);
  const auto refuse = [&](const std::string& text) {
    const fs::path path = Put("picks.pp", text);
    return Message<InputError>(path, [&] { ReadPicks(path, mesh); });
  };
  EXPECT_TRUE(
      Says(refuse("<Foo><point x=\"0\" y=\"0\" z=\"0\" name=\"a\"/></Foo>"), "PickedPoints"));
  EXPECT_TRUE(Says(refuse("<?xml version=\"1.0\"?>\n"), "PickedPoints"));
  constexpr int kLevels = 150;
  std::string deep;
  for (int k = 0; k < kLevels; ++k) deep += "<a>";
  EXPECT_TRUE(Says(refuse(deep), "levels"));
  std::string hidden;  // end tags without a start tag must not hide the depth
  for (int k = 0; k < kLevels; ++k) hidden += "<a b=\"/></a>\"><!-- </a></a> -->";
  EXPECT_TRUE(Says(refuse(hidden), "levels"));
  refuse("<PickedPoints><point x=\"1e300\" y=\"0\" z=\"0\" name=\"a\"/></PickedPoints>");
  std::string flat = "<!DOCTYPE PickedPoints>\n<PickedPoints>\n";
  for (int k = 0; k < 300; ++k)
    flat += "<point x=\"1\" y=\"0\" z=\"0\" active=\"1\" name=\"p" + std::to_string(k) + "\"/>\n";
  EXPECT_EQ(ReadPicks(Put("flat.pp", flat + "</PickedPoints>\n"), MakeIcosphere(3)).size(), 300u);
}

TEST_F(HostilePicks, JsonNestedDeepIsAnInputError) {
  const Mesh mesh = MakeIcosphere(1);
  const std::string deep = std::string(150, '[') + std::string(150, ']');
  const fs::path picks = Put("picks.json", R"({"mesh":)" + deep + R"(,"landmarks":[]})");
  EXPECT_TRUE(Says(Message<InputError>(picks, [&] { ReadPicks(picks, mesh); }), "levels"));
  const fs::path pairs = Put("pairs.json", R"({"source":)" + deep + R"(,"pairs":[]})");
  EXPECT_TRUE(
      Says(Message<InputError>(pairs, [&] { ReadLandmarkPairs({pairs}, mesh, mesh); }), "levels"));
  const fs::path transforms = Put("transforms.json", R"({"frames":)" + deep + "}");
  EXPECT_TRUE(Says(Message<InputError>(transforms, [&] { ReadPoses(transforms); }), "levels"));
  EXPECT_THROW(ParseTimeline(R"({"fps":24,"keys":)" + deep + "}", "timeline.json"), Error);
  EXPECT_TRUE(IsShallowJson(R"({"a":"[[[[[[[[[[[[\"[[[[[[[[[[[[[","b":[[1]]})"));
  EXPECT_TRUE(IsShallowJson("[" + std::string(150, '"') + "]"));
  EXPECT_FALSE(IsShallowJson(deep));
}

}  // namespace keypose::landmarks_io_test
