// The films of a performance's shot over the routes: their frames and masks, and what a person says
// the actor is, kept in pipeline.yaml as `keypose figure` keeps it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "studio/routes/routes.h"

namespace keypose::studio::films_routes_test {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

/// A stage that copies the masks that the test has put beside it.
constexpr char kSilhouettes[] = R"sh(#!/bin/sh
here=$(dirname "$(readlink -f "$0")")
if [ "$1" = --describe ]; then
  cat "$here/silhouettes.json"
  exit
fi
while [ $# -gt 1 ]; do
  case "$1" in
    --masked) cp -r "$here/made" "$2" ;;
    --report) echo '{"schema": 1}' > "$2" ;;
  esac
  shift 2
done
)sh";

constexpr char kProject[] = R"(kind: performance
shots: {walk: films/walk, turn: films/turn}
steps:
  silhouettes: {program: tools/silhouettes, inputs: {video: $unmasked, calibration: null}}
  track: {enabled: false}
  transfer: {enabled: false}
  export: {enabled: false}
  report: {enabled: false}
)";

class FilmsRoutes : public ::testing::Test, public TestingFolder {
 protected:
  FilmsRoutes() {
    for (const char* shot : {"walk", "turn"})
      for (const char* camera : {"cam2", "cam10"})
        for (int frame = 0; frame < 3; ++frame)
          Picture(fs::path("films") / shot / camera / (std::to_string(frame) + ".png"), 3,
                  20 * (frame + 1));
    Picture("films/turn/masks/cam2/0.png", 1, 255);  // given: for one frame of three
    fs::create_directories(folder_ / "tools");
    WriteFile(folder_ / "tools/silhouettes", kSilhouettes);
    fs::permissions(folder_ / "tools/silhouettes", fs::perms::owner_all);
    WriteFile(folder_ / "tools/silhouettes.json", Described());
    for (int frame = 0; frame < 3; ++frame)
      Picture("tools/made/masks/cam2/" + std::to_string(frame) + ".png", 1, 100 + frame);
    WriteFile(folder_ / "pipeline.yaml", kProject);
    routes_ = std::make_unique<Routes>(folder_);
  }
  ~FilmsRoutes() override { routes_.reset(); }

  void Picture(const fs::path& file, int channels, int grey) const {
    fs::create_directories((folder_ / file).parent_path());
    WriteImage(folder_ / file, Image8(60, 40, channels, static_cast<std::uint8_t>(grey)));
  }
  static std::string Described() {
    const auto port = [](const char* name, bool optional, const char* file = "") {
      return json{{"name", name}, {"kind", "folder"}, {"optional", optional}, {"file", file}};
    };
    return json{{"schema", 1},
                {"stage", "silhouettes"},
                {"version", "1"},
                {"summary", "copies"},
                {"inputs", {port("video", false), port("calibration", true)}},
                {"outputs", json::array({port("masked", false, "masked")})},
                {"options", {{{"name", "figure"}, {"type", "string"}, {"default", ""}}}}}
        .dump();
  }
  using Query = std::map<std::string, std::string>;
  Answer Ask(const std::string& path, const Query& query) {
    return routes_->Handle({"GET", path, query, ""});
  }
  json Films(const std::string& shot) {
    return json::parse(Ask("/api/films", {{"shot", shot}}).bytes);
  }
  json Figure(const std::string& shot = "walk") {
    return json::parse(Ask("/api/figure", {{"pose", shot}}).bytes);
  }
  Answer Put(const std::vector<json>& strokes) {
    const json body = {{"revision", Figure().at("revision")}, {"strokes", strokes}};
    return routes_->Handle({"PUT", "/api/figure", {{"pose", "walk"}}, body.dump()});
  }
  static json Stroke(const char* picture, const json& points, bool figure = true) {
    return {{"picture", picture}, {"figure", figure}, {"points", points}};
  }
  std::string Yaml() const { return ReadFile(folder_ / "pipeline.yaml"); }
  void Run() {
    const fs::path log = folder_ / "log";
    const std::string command =
        BinFolder() + "/keypose run -C " + folder_.string() + " > " + log.string() + " 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << ReadFile(log);
    routes_ = std::make_unique<Routes>(folder_);
  }
  std::unique_ptr<Routes> routes_;
};

TEST_F(FilmsRoutes, CamerasAreListedByNumberWithTheirFrames) {
  const json films = Films("walk");
  EXPECT_EQ(films.at("problem"), "");
  ASSERT_EQ(films.at("cameras").size(), 2u);
  const json first = {
      {"name", "cam2"}, {"frames", 3}, {"width", 60}, {"height", 40}, {"masked", false}};
  EXPECT_EQ(films.at("cameras")[0], first);
  EXPECT_EQ(films.at("cameras")[1].at("name"), "cam10");
}

TEST_F(FilmsRoutes, AFrameIsSentAsItIsOrSmaller) {
  const Query second = {{"shot", "walk"}, {"camera", "cam2"}, {"frame", "1"}};
  EXPECT_EQ(ReadImage(Ask("/api/films/frame", second).file, 3).data[0], 40);
  Query small = second;
  small["width"] = "30";
  const Image8 picture = ReadImage(Ask("/api/films/frame", small).file, 3);
  EXPECT_EQ(picture.width, 30);
  EXPECT_NEAR(picture.data[0], 40, 2);  // a JPEG
}

TEST_F(FilmsRoutes, WhatIsNotAFrameOfAFilmIsRefused) {
  const auto status = [&](const char* shot, const char* camera, const char* frame) {
    return Ask("/api/films/frame", {{"shot", shot}, {"camera", camera}, {"frame", frame}}).status;
  };
  EXPECT_EQ(status("none", "cam2", "0"), 400);
  EXPECT_EQ(status("../walk", "cam2", "0"), 400);
  EXPECT_EQ(status("walk", "cam3", "0"), 404);
  EXPECT_EQ(status("walk", "../../tools", "0"), 404);
  EXPECT_EQ(status("walk", "cam2", "3"), 404);
  for (const char* frame : {"-1", "x", "1.5", "99999999999"})
    EXPECT_EQ(status("walk", "cam2", frame), 400) << frame;
  EXPECT_EQ(Ask("/api/films", {{"shot", "none"}}).status, 400);
  EXPECT_EQ(Ask("/api/films", {}).status, 400);
}

TEST_F(FilmsRoutes, FilmsThatAreLinksToOtherPlacesAreLeftOut) {
  fs::create_directory_symlink(folder_ / "films/turn/cam2", folder_ / "films/walk/cam3");
  EXPECT_EQ(Films("walk").at("cameras").size(), 2u);
}

TEST_F(FilmsRoutes, MasksAreThoseBesideTheFilmsOrThoseThatWereMade) {
  const Query second = {{"shot", "walk"}, {"camera", "cam2"}, {"frame", "1"}};
  EXPECT_EQ(Ask("/api/films/mask", second).status, 404);
  Run();
  EXPECT_EQ(Films("walk").at("cameras")[0].at("masked"), true);
  EXPECT_EQ(Films("walk").at("cameras")[1].at("masked"), false);
  EXPECT_EQ(ReadImage(Ask("/api/films/mask", second).file, 1).data[0], 101);
  // Given, but not for each frame.
  EXPECT_EQ(Films("turn").at("cameras")[0].at("masked"), false);
  EXPECT_EQ(Ask("/api/films/mask", {{"shot", "turn"}, {"camera", "cam2"}, {"frame", "0"}}).status,
            200);
}

TEST_F(FilmsRoutes, StrokesAreKeptAsTheCommandLineKeepsThem) {
  const json before = Figure();
  EXPECT_EQ(before.at("step"), "silhouettes/walk");
  EXPECT_EQ(before.at("problem"), "");
  const Answer saved =
      Put({Stroke("cam2/1", {{0.5, 0.25}}), Stroke("cam10/0", {{0, 0}, {1, 1}}, false)});
  ASSERT_EQ(saved.status, 200) << saved.bytes;
  EXPECT_THAT(Yaml(), HasSubstr("walk: {video: films/walk, options: {silhouettes: {figure: "
                                "\"cam2/1:30,10; !cam10/0:0,0-60,40\"}}}"));
  EXPECT_EQ(Figure().at("strokes"), json::parse(saved.bytes).at("strokes"));
  EXPECT_EQ(Figure().at("strokes")[0].at("points"), json({{0.5, 0.25}}));
  ASSERT_EQ(Put({}).status, 200);
  EXPECT_THAT(Yaml(), Not(HasSubstr("figure")));
}

TEST_F(FilmsRoutes, StrokesInNoFrameAreRefusedAndOldOnesAreToldGone) {
  const std::string before = Yaml();
  const json some = json::array({{0.5, 0.5}});
  for (const json& stroke :
       {Stroke("cam2/3", some), Stroke("cam2/-1", some), Stroke("cam2", some),
        Stroke("cam3/0", some), Stroke("../turn/cam2/0", some), Stroke("cam2/0", {{0.5, 1.5}}),
        Stroke("cam2/0", json::array()), json("x")})
    EXPECT_EQ(Put({stroke}).status, 400) << stroke;
  EXPECT_EQ(Yaml(), before);
  ASSERT_EQ(Put({Stroke("cam2/2", some)}).status, 200);
  fs::remove(folder_ / "films/walk/cam2/2.png");
  EXPECT_EQ(Figure().at("strokes")[0].at("gone"), true);
}

TEST_F(FilmsRoutes, AShotThatHasMasksNeedsNoClick) {
  EXPECT_EQ(Figure("turn").at("step"), "");
  EXPECT_THAT(Figure("turn").at("problem"), HasSubstr("a folder masks beside its films"));
}

}  // namespace keypose::studio::films_routes_test
