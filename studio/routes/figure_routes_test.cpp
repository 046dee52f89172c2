// What a person says the figure is, over the routes: kept in pipeline.yaml, in the pixels of the
// photographs, whatever capture has made of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "studio/routes/routes.h"

namespace keypose::studio::figure_routes_test {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class FigureRoutes : public ::testing::Test, public TestingFolder {
 protected:
  FigureRoutes() {
    Photograph("photos/rest/a.png", 60, 40);
    Photograph("photos/rest/b.png", 60, 40);
    Photograph("photos/wave/a.png", 60, 40);
    WriteFile(folder_ / "pipeline.yaml",
              "# mine\nposes:\n  rest: photos/rest\n  wave: {photos: photos/wave, method: fit}\n");
    routes_ = std::make_unique<Routes>(folder_);
  }
  ~FigureRoutes() override { routes_.reset(); }

  void Photograph(const fs::path& file, int width, int height, int orientation = 1) const {
    fs::create_directories((folder_ / file).parent_path());
    ExifToWrite exif;
    exif.orientation = orientation;
    WriteImage(folder_ / file, Image8(width, height, 3, 90), 90, &exif);
  }
  std::string Yaml() const { return ReadFile(folder_ / "pipeline.yaml"); }
  json Get(const std::string& pose = "rest") {
    const Answer answer = routes_->Handle({"GET", "/api/figure", {{"pose", pose}}, ""});
    EXPECT_EQ(answer.status, 200) << answer.bytes;
    return json::parse(answer.bytes);
  }
  using Strokes = std::vector<json>;
  Answer Put(const Strokes& strokes, const std::string& revision,
             const std::string& pose = "rest") {
    return PutAny(json(strokes), revision, pose);
  }
  Answer PutAny(const json& strokes, const std::string& revision, const std::string& pose) {
    const json body = {{"revision", revision}, {"strokes", strokes}};
    return routes_->Handle({"PUT", "/api/figure", {{"pose", pose}}, body.dump()});
  }
  Answer Put(const Strokes& strokes) { return Put(strokes, Get().at("revision")); }
  static json Stroke(const char* picture, const json& points, bool figure = true) {
    return {{"picture", picture}, {"figure", figure}, {"points", points}};
  }
  std::unique_ptr<Routes> routes_;
};

TEST_F(FigureRoutes, ClicksAreKeptInPixelsOfThePhotographs) {
  const json before = Get();
  EXPECT_EQ(before.at("step"), "masks/rest");
  EXPECT_EQ(before.at("problem"), "");
  EXPECT_EQ(before.at("unclear"), "");
  EXPECT_TRUE(before.at("strokes").empty());
  const std::vector<std::string> follow = before.at("follow");
  EXPECT_THAT(follow, ::testing::Contains("mesh/rest"));
  EXPECT_THAT(follow, Not(::testing::Contains("sfm/rest")));
  const Answer saved =
      Put({Stroke("a.png", {{0.5, 0.25}}), Stroke("b.png", {{0, 0}, {1, 1}}, false)});
  ASSERT_EQ(saved.status, 200) << saved.bytes;
  EXPECT_EQ(
      Yaml(),
      "# mine\nposes:\n  rest: {photos: photos/rest, options: {masks: {figure: \"a.png:30,10; "
      "!b.png:0,0-60,40\"}}}\n  wave: {photos: photos/wave, method: fit}\n");
  const json after = Get();
  EXPECT_EQ(after.at("strokes"), json::parse(saved.bytes).at("strokes"));
  EXPECT_EQ(after.at("revision"), json::parse(saved.bytes).at("revision"));
  EXPECT_EQ(after.at("strokes")[0].at("points"), json({{0.5, 0.25}}));
  EXPECT_EQ(after.at("strokes")[1].at("figure"), false);
}

TEST_F(FigureRoutes, WhatStaysIsKeptToTheLastDigitAndAllOfItCanGo) {
  WriteFile(folder_ / "pipeline.yaml",
            "poses: {rest: {photos: photos/rest, options: {masks: {figure: \"a.png:1.23456,7 "
            "old.png:5,6\"}}}}\n");
  routes_ = std::make_unique<Routes>(folder_);
  Strokes strokes = Get().at("strokes");
  EXPECT_EQ(strokes[0].at("gone"), false);
  EXPECT_EQ(strokes[1].at("gone"), true);
  EXPECT_EQ(strokes[1].at("picture"), "old.png");
  strokes.push_back(Stroke("b.png", {{0.1, 0.1}}));
  ASSERT_EQ(Put(strokes).status, 200);
  EXPECT_THAT(Yaml(), HasSubstr("\"a.png:1.23456,7; old.png:5,6; b.png:6,4\""));
  ASSERT_EQ(Put({}).status, 200);
  EXPECT_EQ(Yaml(), "poses: {rest: {photos: photos/rest}}\n");
}

TEST_F(FigureRoutes, WhatWasChangedMeanwhileIsNotWrittenOver) {
  const std::string revision = Get().at("revision");
  ASSERT_EQ(Put({Stroke("a.png", {{0.5, 0.5}})}, revision).status, 200);
  EXPECT_EQ(Put({Stroke("b.png", {{0.5, 0.5}})}, revision).status, 409);
  EXPECT_THAT(Yaml(), Not(HasSubstr("b.png")));
}

TEST_F(FigureRoutes, PosesOfFewPhotographsTellCapture) {
  const json now = Get("wave");
  EXPECT_EQ(now.at("step"), "capture/wave");
  ASSERT_EQ(Put({Stroke("a.png", {{0.5, 0.5}})}, now.at("revision"), "wave").status, 200);
  EXPECT_THAT(Yaml(), HasSubstr("options: {capture: {figure: \"a.png:30,20\"}}"));
}

TEST_F(FigureRoutes, UprightPhotographsAreMeasuredAsTheyAreShown) {
  Photograph("photos/rest/up.jpg", 60, 40, 6);  // a viewer shows 40 x 60
  ASSERT_EQ(Put({Stroke("up.jpg", {{0.25, 0.5}})}).status, 200);
  EXPECT_THAT(Yaml(), HasSubstr("up.jpg:10,30"));
}

TEST_F(FigureRoutes, PhotographsInSubfoldersAreNamedWithThem) {
  fs::remove_all(folder_ / "photos/rest");
  Photograph("photos/rest/lying/c.png", 60, 40);
  Photograph("photos/rest/upright/c.png", 60, 40);
  const Answer saved = Put({Stroke("lying_c.png", {{0.5, 0.5}})});
  ASSERT_EQ(saved.status, 200) << saved.bytes;
  EXPECT_THAT(Yaml(), HasSubstr("lying/c.png:30,20"));
}

TEST_F(FigureRoutes, WhatCannotBeIsRefusedAndNothingIsWritten) {
  const std::string before = Yaml();
  const json some = json::array({{0.5, 0.5}});
  for (const json& stroke : {Stroke("none.png", some), Stroke("../rest/a.png", some),
                             Stroke("a.png", {{0.5, 1.5}}), Stroke("a.png", json::array()),
                             Stroke("a.png", {{0.5, nullptr}}), json("x"), json{{"text", "a.png"}}})
    EXPECT_EQ(Put({stroke}).status, 400) << stroke;
  EXPECT_EQ(PutAny("x", Get().at("revision"), "rest").status, 400);
  EXPECT_EQ(routes_->Handle({"GET", "/api/figure", {{"pose", "none"}}, ""}).status, 400);
  EXPECT_EQ(Put({}, Get().at("revision"), "none").status, 400);
  EXPECT_EQ(Yaml(), before);
}

TEST_F(FigureRoutes, ATextThatCannotBeReadIsToldAndCanBeReplaced) {
  WriteFile(folder_ / "pipeline.yaml",
            "poses: {rest: {photos: photos/rest, options: {masks: {figure: a.png}}}}\n");
  routes_ = std::make_unique<Routes>(folder_);
  const json now = Get();
  EXPECT_THAT(now.at("problem"), HasSubstr("'a.png' has no ':'"));
  EXPECT_EQ(now.at("step"), "masks/rest");
  ASSERT_EQ(Put({Stroke("a.png", {{0.5, 0.5}})}).status, 200);
  EXPECT_EQ(Get().at("problem"), "");
}

/// A stage that copies what the test has put there.
constexpr char kCapture[] = R"sh(#!/bin/sh
here=$(dirname "$(readlink -f "$0")")
if [ "$1" = --describe ]; then
  cat "$here/capture.json"
  exit
fi
while [ $# -gt 1 ]; do
  case "$1" in
    --images) cp -r "$here/made" "$2"; made=$2 ;;
    --report) cp "$here/report.json" "$2" ;;
  esac
  shift 2
done
if [ -e "$here/failed.jpg" ]; then cp "$here/failed.jpg" "$made.failed.jpg"; fi
if [ -e "$here/fault" ]; then
  cat "$here/fault" >&2
  exit 3
fi
)sh";

/// After a run of which only capture is left.
class FigureAfterCapture : public FigureRoutes {
 protected:
  FigureAfterCapture() {
    Photograph("photos/wave/tall.png", 40, 60);
    WriteMade();
    WriteFile(folder_ / "tools/capture", kCapture);
    fs::permissions(folder_ / "tools/capture", fs::perms::owner_all);
    WriteFile(folder_ / "tools/capture.json", Described());
    Report(json::object());
    std::string steps;
    for (const char* step :
         {"sfm", "masks", "dense", "mesh", "refine", "cleanup", "unwrap", "register", "fit", "bake",
          "complete", "interpolate", "export", "report"})
      steps += std::string("  ") + step + ": {enabled: false}\n";
    WriteFile(folder_ / "pipeline.yaml",
              "poses:\n  rest: photos/rest\n  wave: {photos: photos/wave, method: fit}\nsteps:\n" +
                  steps +
                  "  capture: {program: tools/capture, inputs: {masks: null, background: null}}\n");
  }

  /// Pictures of half the size; the portrait is turned clockwise, as capture turns one among
  /// landscapes.
  void WriteMade() const {
    ImageSet set;
    set.folder = folder_ / "tools/made";
    fs::create_directories(set.folder / "masks");
    for (const char* name : {"a.png", "tall.png"}) {
      CapturedImage image;
      image.name = name;
      image.mask = std::string("masks/") + name;
      image.width = 30, image.height = 20;
      set.images.push_back(image);
      WriteImage(set.folder / image.name, Image8(30, 20, 3, 90));
      WriteImage(set.folder / image.mask, Image8(30, 20, 1, 255));
    }
    WriteImageSet(set);
    WriteImage(set.folder / "contact_sheet.jpg", Image8(30, 20, 3, 90));
  }
  static std::string Described() {
    const auto port = [](const char* name, bool optional, const char* file = "") {
      return json{{"name", name}, {"kind", "folder"}, {"optional", optional}, {"file", file}};
    };
    const json options = {{{"name", "min_images"}, {"type", "int"}, {"default", 3}},
                          {{"name", "figure"}, {"type", "string"}, {"default", ""}}};
    return json{{"schema", 1},
                {"stage", "capture"},
                {"version", "1"},
                {"inputs", {port("photos", false), port("masks", true), port("background", true)}},
                {"outputs", json::array({port("images", false, "images")})},
                {"options", options},
                {"summary", "copies"}}
        .dump();
  }
  void Report(const json& report) const {
    json whole = {{"schema", 1}};
    whole.update(report);
    WriteFile(folder_ / "tools/report.json", whole.dump());
  }
  Answer Failed(const std::string& step, const std::string& picture) {
    return routes_->Handle({"GET", "/api/failed", {{"step", step}, {"picture", picture}}, ""});
  }
  int Run() {
    const fs::path log = folder_ / "log";
    const std::string command = BinFolder() + "/keypose run -C " + folder_.string() +
                                " --force capture > " + log.string() + " 2>&1";
    const int status = std::system(command.c_str());
    routes_ = std::make_unique<Routes>(folder_);
    return status;
  }
};

TEST_F(FigureAfterCapture, PlacesAreThoseOfThePhotographHoweverCaptureTurnedIt) {
  ASSERT_EQ(Run(), 0) << ReadFile(folder_ / "log");
  const json now = Get("wave");
  EXPECT_EQ(now.at("sheet"), "wave/masks.jpg");
  // Of the turned picture, the lower left corner is the photograph's lower right.
  const Answer saved =
      Put({Stroke("tall.png", {{0, 1}, {0.25, 0.5}}), Stroke("a.png", {{0.5, 0.25}})},
          now.at("revision"), "wave");
  ASSERT_EQ(saved.status, 200) << saved.bytes;
  EXPECT_THAT(Yaml(), HasSubstr("\"tall.png:40,60-20,45; a.png:30,10\""));
  EXPECT_EQ(Get("wave").at("strokes")[0].at("points"), json({{0.0, 1.0}, {0.25, 0.5}}));
}

TEST_F(FigureAfterCapture, AClickIsAskedForWhenAStepSaysSo) {
  ASSERT_EQ(Run(), 0);
  EXPECT_EQ(Get().at("unclear"), "");
  Report({{"measurements", {{"figure_unclear", true}}}});
  ASSERT_EQ(Run(), 0);
  EXPECT_EQ(Get().at("unclear"), "the photographs do not tell what the figure is");
  Report({{"warnings", {"dark", "two things stand there; click on one, or `keypose figure`"}}});
  ASSERT_EQ(Run(), 0);
  EXPECT_THAT(Get().at("unclear"), HasSubstr("two things stand there"));
  Report(json::object());
  WriteFile(folder_ / "tools/fault",
            "keypose capture: error: say with `keypose figure` what it is\n");
  ASSERT_NE(Run(), 0);
  EXPECT_EQ(Get().at("unclear"), "say with `keypose figure` what it is");
  // With another stroke it has not failed yet.
  ASSERT_EQ(Put({Stroke("a.png", {{0.5, 0.5}})}).status, 200);
  routes_ = std::make_unique<Routes>(folder_);
  EXPECT_EQ(Get().at("unclear"), "");
}

TEST_F(FigureAfterCapture, WhatWasTakenForTheFigureIsShownUntilItIsTold) {
  WriteImage(folder_ / "tools/failed.jpg", Image8(64, 48, 3, 90));
  WriteFile(folder_ / "tools/fault",
            "keypose capture: error: it cannot be told what the figure is; click it with `keypose "
            "figure`; what was taken for the figure: /somewhere/images.failed.jpg\n");
  ASSERT_NE(Run(), 0);
  EXPECT_EQ(Get().at("unclear"),
            "it cannot be told what the figure is; click it with `keypose figure`");
  const json refused = Get().at("refused");
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_EQ(refused[0].at("step"), "capture/rest");
  EXPECT_EQ(refused[0].at("picture"), "images.failed.jpg");
  const auto steps = json::parse(routes_->Handle({"GET", "/api/steps", {}, ""}).bytes).at("steps");
  EXPECT_EQ(steps[0].at("pictures"), refused);
  EXPECT_EQ(ReadImage(Failed("capture/rest", "images.failed.jpg").file, 3).width, 64);
  // One stroke may not be enough: it stays to be looked at while there are more.
  ASSERT_EQ(Put({Stroke("a.png", {{0.5, 0.5}})}).status, 200);
  EXPECT_EQ(Get().at("refused"), refused);
  fs::remove(folder_ / "tools/fault");
  ASSERT_EQ(Run(), 0);
  EXPECT_EQ(Get().at("refused"), json::array());
  EXPECT_EQ(Failed("capture/rest", "images.failed.jpg").status, 404);
}

TEST_F(FigureAfterCapture, OnlyPicturesThatAStepLeftAreSent) {
  WriteImage(folder_ / "tools/failed.jpg", Image8(64, 48, 3, 90));
  WriteFile(folder_ / "tools/fault", "keypose capture: error: no\n");
  ASSERT_NE(Run(), 0);
  EXPECT_EQ(Get().at("refused"), json::array());  // it did not ask for a click
  for (const char* name :
       {"log.txt", "../log.txt", "../../../pipeline.yaml", "", "none.failed.jpg"})
    EXPECT_EQ(Failed("capture/rest", name).status, 404) << name;
  EXPECT_EQ(Failed("capture/none", "images.failed.jpg").status, 400);
  EXPECT_EQ(Failed("../capture", "images.failed.jpg").status, 400);
}

}  // namespace keypose::studio::figure_routes_test
