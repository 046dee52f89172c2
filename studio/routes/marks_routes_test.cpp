// Marks of a performance over the routes: on the tracked body and a scan that is sent in pieces;
// saved, suggested, and why none is suggested. New performances and their films.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "studio/routes/routes.h"
#include "views/decode/testing/test_film.h"

namespace keypose::studio::marks_routes_test {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
using Query = std::map<std::string, std::string>;

/// A stage that gives the body that the test has put beside it.
constexpr char kTrack[] = R"sh(#!/bin/sh
here=$(dirname "$(readlink -f "$0")")
if [ "$1" = --describe ]; then
  cat "$here/track.json"
  exit
fi
while [ $# -gt 1 ]; do
  case "$1" in
    --frames) mkdir "$2"; cp "$here/body.ply" "$2/frame_0000.ply"
      echo '{}' | tee "$2/actor.json" "$2/angles.csv" > "$2/distortion.json" ;;
    --reference) cp "$here/body.ply" "$2" ;;
    --motion|--picture) echo made > "$2" ;;
    --report) echo '{"schema": 1, "measurements": {}}' > "$2" ;;
  esac
  shift 2
done
)sh";

constexpr char kProject[] = R"(# a comment
kind: performance
shots: {walk: films/walk}
steps:
  silhouettes: {enabled: false}
  track: {program: tools/track, inputs: {video: $video, masks: null, calibration: null, actor: null}}
  export: {enabled: false}
  report: {enabled: false}
)";

class MarksRoutes : public ::testing::Test, public TestingFolder {
 protected:
  MarksRoutes() { routes_ = std::make_unique<Routes>(folder_); }
  ~MarksRoutes() override { routes_.reset(); }

  void MakeProject(const Mesh& body = Body()) {
    fs::create_directories(folder_ / "films/walk");
    fs::create_directories(folder_ / "tools");
    WriteFile(folder_ / "films/walk/cam1.mp4", "film");
    WriteMesh(folder_ / "tools/body.ply", body);
    WriteFile(folder_ / "tools/track", kTrack);
    fs::permissions(folder_ / "tools/track", fs::perms::owner_all);
    const auto port = [](const char* name, const char* kind, const char* file = "") {
      return json{{"name", name}, {"kind", kind}, {"optional", true}, {"file", file}};
    };
    WriteFile(folder_ / "tools/track.json",
              json{{"schema", 1},
                   {"stage", "track"},
                   {"version", "1"},
                   {"summary", "copies"},
                   {"inputs",
                    {port("video", "path"), port("masks", "path"), port("calibration", "path"),
                     port("actor", "path")}},
                   {"outputs",
                    {port("frames", "folder"), port("reference", "file", "body.ply"),
                     port("motion", "file", "motion.bvh"), port("picture", "file", "tracked.jpg")}},
                   {"options", json::array()}}
                  .dump());
    WriteFile(folder_ / "pipeline.yaml", kProject);
    const fs::path log = folder_ / "log";
    const std::string run =
        BinFolder() + "/keypose run -C " + folder_.string() + " > " + log.string() + " 2>&1";
    ASSERT_EQ(std::system(run.c_str()), 0) << ReadFile(log);
    routes_ = std::make_unique<Routes>(folder_);
  }
  /// A trunk with a long arm, unlike on both sides.
  static Mesh Body() {
    Mesh mesh = MakeIcosphere(3);
    for (Eigen::Index i = 0; i < mesh.points.rows(); ++i)
      if (mesh.points(i, 2) > 0.6) mesh.points(i, 2) += 6 * (mesh.points(i, 2) - 0.6);
    return mesh;
  }
  /// Nothing of a ball.
  static Mesh Ring() {
    constexpr int kAround = 24, kThick = 12;
    Mesh mesh;
    mesh.points.resize(kAround * kThick, 3);
    mesh.faces.resize(2 * kAround * kThick, 3);
    for (int i = 0; i < kAround; ++i)
      for (int j = 0; j < kThick; ++j) {
        const double turn = 2 * M_PI * i / kAround, roll = 2 * M_PI * j / kThick;
        const double out = 0.5 + 0.2 * std::cos(roll);
        const int here = i * kThick + j, next = (i + 1) % kAround * kThick;
        mesh.points.row(here) << out * std::cos(turn), out * std::sin(turn), 0.2 * std::sin(roll);
        mesh.faces.row(2 * here) << here, next + j, next + (j + 1) % kThick;
        mesh.faces.row(2 * here + 1) << here, next + (j + 1) % kThick,
            i * kThick + (j + 1) % kThick;
      }
    return mesh;
  }
  json Get(const std::string& path, const Query& query = {}) {
    const Answer answer = routes_->Handle({"GET", path, query, ""});
    EXPECT_EQ(answer.status, 200) << answer.bytes;
    return json::parse(answer.bytes);
  }
  Answer Send(const char* method, const std::string& path, const json& body) {
    return routes_->Handle({method, path, {}, body.dump()});
  }
  Answer Piece(const std::string& place, const std::string& name, std::size_t at, std::size_t size,
               const std::string& bytes, const std::string& shot = "") {
    return routes_->Handle({"PUT",
                            "/api/upload",
                            {{"place", place},
                             {"shot", shot},
                             {"name", name},
                             {"at", std::to_string(at)},
                             {"size", std::to_string(size)}},
                            bytes});
  }
  void SendScan(const Mesh& mesh, const std::string& name) {
    WriteMesh(folder_ / "made.ply", mesh);
    const std::string bytes = ReadFile(folder_ / "made.ply");
    const std::size_t half = bytes.size() / 2;
    ASSERT_EQ(Piece("scan", name, 0, bytes.size(), bytes.substr(0, half)).status, 200);
    const Answer done = Piece("scan", name, half, bytes.size(), bytes.substr(half));
    ASSERT_EQ(json::parse(done.bytes).value("file", ""), "scan/" + name) << done.bytes;
    const Answer used = Send("POST", "/api/marks/scan", {{"scan", "scan/" + name}});
    ASSERT_EQ(used.status, 200) << used.bytes;
  }
  static json Place(const std::string& name, int face) {
    return {{"name", name}, {"face", face}, {"barycentric", {0.5, 0.25, 0.25}}};
  }
  static json Pair(const std::string& name, int face) {
    return {{"source", Place(name, face)}, {"target", Place(name, face + 1)}};
  }
  std::string Yaml() const { return ReadFile(folder_ / "pipeline.yaml"); }

  std::unique_ptr<Routes> routes_;
};

TEST_F(MarksRoutes, MarksAreSavedAsTransferReadsThemAndGoWithTheLastOne) {
  MakeProject();
  EXPECT_TRUE(Get("/api/marks")["body"]["there"]);
  EXPECT_THAT(Get("/api/marks")["scan"]["missing"], HasSubstr("No mesh is named yet"));
  SendScan(Body(), "hero.ply");
  EXPECT_THAT(Yaml(), HasSubstr("# a comment"));
  EXPECT_THAT(Yaml(), HasSubstr("scan: scan/hero.ply"));
  const Answer saved =
      Send("PUT", "/api/marks", {{"pairs", {Pair("hand", 7), Pair("foot", 20)}}, {"revision", ""}});
  ASSERT_EQ(saved.status, 200) << saved.bytes;
  const auto pairs = ReadLandmarkPairs({folder_ / "marks.json"}, Body(), Body());
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].name, "hand");
  EXPECT_EQ(pairs[0].source.face, 7);
  EXPECT_EQ(pairs[0].target.face, 8);
  EXPECT_TRUE(pairs[0].confirmed);
  EXPECT_DOUBLE_EQ(pairs[1].target.barycentric[0], 0.5);
  // The plan has the step that moves the scan now.
  EXPECT_THAT(Get("/api/steps").dump(), HasSubstr("\"transfer/walk\""));
  const json page = Get("/api/marks");
  EXPECT_EQ(page["pairs"].size(), 2u);
  EXPECT_EQ(Send("PUT", "/api/marks", {{"pairs", json::array()}, {"revision", "old"}}).status, 409);
  const json none = {{"pairs", json::array()}, {"revision", page["revision"]}};
  ASSERT_EQ(Send("PUT", "/api/marks", none).status, 200);
  EXPECT_FALSE(fs::exists(folder_ / "marks.json"));
}

TEST_F(MarksRoutes, MarksThatCannotBeAreRefused) {
  MakeProject();
  SendScan(Body(), "hero.ply");
  const auto refused = [&](const json& pair) {
    const Answer answer =
        Send("PUT", "/api/marks", {{"pairs", json::array({pair})}, {"revision", ""}});
    EXPECT_EQ(answer.status, 400);
    return answer.bytes;
  };
  EXPECT_THAT(refused(Pair("hand", 999999)), HasSubstr("is on face 999999"));
  json renamed = Pair("hand", 3);
  renamed["target"]["name"] = "foot";
  EXPECT_THAT(refused(renamed), HasSubstr("called 'hand' on the body and 'foot' on the scan"));
  EXPECT_FALSE(fs::exists(folder_ / "marks.json"));
  WriteFile(folder_ / "marks.json", "{\"pairs\": 7}");
  EXPECT_NE(Get("/api/marks")["problem"], "");
  const json over = {{"pairs", {Pair("hand", 3)}}, {"revision", Get("/api/marks")["revision"]}};
  EXPECT_THAT(Send("PUT", "/api/marks", over).bytes, HasSubstr("mend or delete it"));
  EXPECT_EQ(ReadFile(folder_ / "marks.json"), "{\"pairs\": 7}");
}

TEST_F(MarksRoutes, SuggestedMarksAreOfferedAndNoneIsExplained) {
  MakeProject();
  SendScan(Body(), "hero.ply");
  json found = json::parse(Send("POST", "/api/marks/suggest", {{"count", 5}}).bytes);
  EXPECT_EQ(found["pairs"].size(), 5u) << found;
  EXPECT_EQ(found["why_none"], "");
  EXPECT_EQ(Get("/api/marks")["pairs"].size(), 0u) << "a suggestion is no mark yet";
}

TEST_F(MarksRoutes, WhyNoneIsSuggestedIsSaidWithWhatToDo) {
  MakeProject(MakeIcosphere(3));
  SendScan(Ring(), "ring.ply");
  const json found = json::parse(Send("POST", "/api/marks/suggest", {{"count", 5}}).bytes);
  EXPECT_EQ(found["pairs"].size(), 0u) << found;
  EXPECT_THAT(found["why_none"], HasSubstr("no pair is suggested: the surest has the confidence"));
  EXPECT_THAT(found["why_none"], HasSubstr("Pick three pairs yourself"));
}

TEST_F(MarksRoutes, APerformanceIsMadeOfFilmsThatAreSent) {
  const Answer made =
      Send("POST", "/api/project", {{"shots", {"walk"}}, {"video3d", true}, {"surface", true}});
  ASSERT_EQ(made.status, 200) << made.bytes;
  EXPECT_THAT(Yaml(), HasSubstr("    video: shots/walk\n"));
  EXPECT_THAT(Yaml(), HasSubstr("video3d: {enabled: true}"));
  EXPECT_THAT(Yaml(), HasSubstr("follow: {enabled: true}"));
  WriteImage(folder_ / "0.png", Image8(60, 40, 3, 90));
  const std::string picture = ReadFile(folder_ / "0.png");
  for (const char* name : {"cam1/0000.png", "cam1/0001.png", "cam2/0000.png", "cam2/0001.png"})
    ASSERT_EQ(Piece("shot", name, 0, picture.size(), picture, "walk").status, 200) << name;
  // Before there is a calibration, and so no plan.
  EXPECT_TRUE(fs::exists(folder_ / "shots/walk/cam2/0001.png"));
  ASSERT_EQ(Piece("calibration", "rig.yml", 0, 4, "one\n").status, 200);
  ASSERT_EQ(Piece("calibration", "other.yml", 0, 4, "two\n").status, 200);
  EXPECT_EQ(ReadFile(folder_ / "calibration.yml"), "two\n");
  EXPECT_EQ(ReadFile(folder_ / "calibration.before.yml"), "one\n");
  EXPECT_EQ(Send("POST", "/api/films/shot", {{"shot", "turn"}}).status, 200);
  EXPECT_THAT(Yaml(), HasSubstr("video: shots/turn"));
  EXPECT_EQ(Send("POST", "/api/films/shot", {{"shot", "turn"}}).status, 400);
}

TEST_F(MarksRoutes, WhatCannotBeSentIsRefusedByName) {
  ASSERT_EQ(Send("POST", "/api/project", {{"shots", {"walk"}}}).status, 200);
  const auto words = [&](const std::string& place, const std::string& name,
                         const std::string& bytes) {
    const Answer answer = Piece(place, name, 0, bytes.size(), bytes, "walk");
    EXPECT_EQ(answer.status, 400) << answer.bytes;
    return answer.bytes;
  };
  EXPECT_THAT(words("shot", "cam1.mp4", "no film at all"), HasSubstr("does not hold one"));
  EXPECT_THAT(words("shot", "notes.txt", "x"), HasSubstr("'notes.txt' is no film"));
  EXPECT_THAT(words("shot", "../cam1.mp4", "x"), HasSubstr("cannot be the name of a file"));
  EXPECT_THAT(words("scan", "hero.exe", "x"), HasSubstr("none of meshes"));
  EXPECT_THAT(words("home", "a.txt", "x"), HasSubstr("cannot be sent to 'home'"));
  ASSERT_EQ(Piece("armature", "puppet.txt", 0, 1, "x").status, 200);
  EXPECT_THAT(words("armature", "puppet.txt", "y"), HasSubstr("there is another puppet.txt"));
  ASSERT_EQ(Piece("armature", "puppet.txt", 0, 1, "x").status, 200) << "the same file again";
  EXPECT_EQ(ReadFile(folder_ / "armature/puppet.txt"), "x");
  // A piece that does not follow on the last one is not taken; the page is told where it stands.
  ASSERT_EQ(Piece("armature", "long.txt", 0, 6, "abc").status, 200);
  const json told = json::parse(Piece("armature", "long.txt", 5, 6, "f").bytes);
  EXPECT_EQ(told, (json{{"sent", 3}, {"file", ""}}));
  ASSERT_EQ(Piece("armature", "long.txt", 3, 6, "def").status, 200);
  EXPECT_EQ(ReadFile(folder_ / "armature/long.txt"), "abcdef");
}

TEST_F(MarksRoutes, AVideoThatIsSentIsCutIntoTheNumberedPicturesOfAShot) {
  TestFilmKind kind;
  kind.rate = 12;
  WriteTestFilm(folder_ / "made.mkv", kind, {0, 7500, 15000, 22500});
  const std::string bytes = ReadFile(folder_ / "made.mkv");
  WriteFile(folder_ / "pipeline.yaml", "poses: {rest: photos/rest, wave: photos/wave}\n");
  const Answer sent = Piece("film", "take1.mkv", 0, bytes.size(), bytes);
  ASSERT_EQ(sent.status, 200) << sent.bytes;
  for (int again = 0; again < 2; ++again) {
    const Answer cut = Send("POST", "/api/shot/cut", {{"video", "films/take1.mkv"}});
    ASSERT_EQ(cut.status, 200) << cut.bytes;
    EXPECT_EQ(json::parse(cut.bytes),
              (json{{"folder", "films/take1"}, {"pictures", 4}, {"fps", 12.0}}));
  }
  EXPECT_EQ(NumberIn(ReadImage(folder_ / "films/take1/take1_0003.png", 3)), 3);
  EXPECT_EQ(Send("POST", "/api/shot/cut", {{"video", "films/none.mkv"}}).status, 400);
}

}  // namespace keypose::studio::marks_routes_test
