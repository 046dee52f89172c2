// Picks in photographs over the routes: read, checked, saved, refused; what a fit says of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <memory>
#include <thread>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/project/regions_io.h"
#include "core/io/text/files.h"
#include "core/pictures/render.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "studio/project/snapshot.h"
#include "studio/routes/routes.h"

namespace keypose::studio::landmarks_routes_test {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kWidth = 400, kHeight = 300;

/// Stages that copy what the test has put there: a stage is any program that follows the contract.
constexpr char kCopy[] = R"sh(#!/bin/sh
here=$(dirname "$(readlink -f "$0")")
name=$(basename "$0")
if [ "$1" = --describe ]; then
  cat "$here/$name.json"
  exit
fi
while [ $# -gt 1 ]; do
  case "$1" in
    --images|--fitted|--model|--unwrapped|--picture) cp -r "$here/made_${1#--}" "$2" ;;
    --report) cp "$here/$name.report" "$2" ;;
  esac
  shift 2
done
)sh";

std::string Described(const std::string& stage, const json& inputs, const json& outputs) {
  // The default pipeline sets this option of capture.
  const json options =
      stage == "capture" ? json::array({{{"name", "min_images"}, {"type", "int"}, {"default", 3}}})
                         : json::array();
  return json{{"schema", 1},        {"stage", stage},     {"version", "1"},     {"inputs", inputs},
              {"outputs", outputs}, {"options", options}, {"summary", "copies"}}
      .dump();
}

constexpr char kFitReport[] = R"({"schema": 1, "measurements": {
    "views": [{"image": "a_40.png", "iou": 0.9,
               "worst": {"pixel": [3, 4], "distance_px": 7, "beyond": "mask"}}],
    "landmarks_off": [{"name": "nose", "image": "a_0.png", "off_px": 80, "refused": true}]}})";

constexpr char kSteps[] =
    "  capture:\n    program: tools/capture\n"
    "    inputs: {masks: null, background: null}\n"
    "  unwrap: {program: tools/unwrap, inputs: {clean: null}}\n"
    "  fit:\n    program: tools/fit\n"
    "    inputs: {texture: null, rig: null, stiffness: null, landmarks: null}\n";

class PhotoPicks : public ::testing::Test {
 protected:
  /// One project with photographs that were read, which each test gets as a copy: to ask all
  /// programs what they are takes most of the time.
  static void SetUpTestSuite() {
    own_made = std::make_unique<TestingFolder>();
    made = own_made->path();
    for (const char* folder :
         {"photos/rest", "photos/wave", "tools/made_images/masks", "tools/made_model", "landmarks"})
      fs::create_directories(made / folder);
    for (const int degrees : {0, 40, 80}) scene.views.push_back(ViewAt(degrees));
    WritePhotographs();
    WriteMesh(made / "tools/made_fitted.ply", mesh);
    fs::rename(made / "tools/made_fitted.ply", made / "tools/made_fitted");
    fs::copy(made / "tools/made_fitted", made / "tools/made_unwrapped");
    WriteColmapModel(made / "tools/made_model", scene);
    AddTools();
    WriteFile(made / "pipeline.yaml", ProjectText(""));
    Run(made, "capture");
  }
  static void TearDownTestSuite() { own_made.reset(); }

  PhotoPicks() {
    fs::create_directories(place_ / "outside");
    fs::copy(made, folder_, fs::copy_options::recursive | fs::copy_options::copy_symlinks);
  }
  ~PhotoPicks() override { routes_.reset(); }

  static View ViewAt(int degrees) {
    View view = FitView(mesh.points, degrees, 10, kWidth, kHeight);
    view.name = "a_" + std::to_string(degrees) + ".png";
    return view;
  }
  static void WritePhotographs() {
    ImageSet set;
    set.folder = made / "tools/made_images";
    for (const View& view : scene.views) {
      CapturedImage image;
      image.name = view.name;
      image.mask = "masks/" + view.name;
      image.width = kWidth;
      image.height = kHeight;
      set.images.push_back(image);
      WriteImage(set.folder / image.name, Image8(kWidth, kHeight, 3, 90));
      WriteImage(set.folder / image.mask, Image8(kWidth, kHeight, 1, 255));
      for (const char* pose : {"rest", "wave"})
        fs::copy(set.folder / image.name, made / "photos" / pose / image.name);
    }
    WriteImageSet(set);
  }
  static json Port(const char* name, const char* kind, const char* file = "") {
    json port = {{"name", name}, {"kind", kind}};
    if (*file) port["file"] = file;
    return port;
  }
  static json Optional(const char* name) {
    json port = Port(name, "path");
    port["optional"] = true;
    return port;
  }
  static void AddTools() {
    const json images = Port("images", "folder");
    AddTool("capture", {Port("photos", "folder"), Optional("masks"), Optional("background")},
            json::array({images}));
    AddTool("unwrap", json::array({Optional("clean")}),
            json::array({Port("unwrapped", "file", "mesh.ply")}));
    AddTool("fit",
            {Port("template", "file"), images, Optional("texture"), Optional("rig"),
             Optional("stiffness"), Optional("landmarks")},
            {Port("fitted", "file", "fitted.ply"), Port("model", "folder"),
             Port("picture", "file", "fitted.png")});
    WriteFile(made / "tools/fit.report", kFitReport);
    WriteFile(made / "tools/made_picture", "picture");
  }
  static void AddTool(const std::string& name, const json& inputs, const json& outputs) {
    const fs::path program = made / "tools" / name;
    WriteFile(program, kCopy);
    fs::permissions(program, fs::perms::owner_all);
    WriteFile(made / "tools" / (name + ".json"), Described(name, inputs, outputs));
    WriteFile(made / "tools" / (name + ".report"), R"({"schema": 1, "measurements": {}})");
  }
  /// A project in which only these three steps are left.
  static std::string ProjectText(const std::string& wave, const std::string& rest = "photos/rest") {
    std::string steps;
    for (const char* step : {"sfm", "masks", "dense", "mesh", "refine", "cleanup", "register",
                             "bake", "complete", "interpolate", "export", "report"})
      steps += std::string("  ") + step + ": {enabled: false}\n";
    return "name: dance\nposes:\n  rest: " + rest + "\n  wave: {photos: photos/wave, method: fit" +
           wave + "}\ntemplate: rest\nsteps:\n" + steps + kSteps;
  }
  void Project(const std::string& wave, const std::string& rest = "photos/rest") {
    routes_.reset();
    WriteFile(folder_ / "pipeline.yaml", ProjectText(wave, rest));
  }
  std::string Text() const { return ReadFile(folder_ / "pipeline.yaml"); }
  static void Run(const fs::path& folder, const std::string& until) {
    const fs::path log = folder.string() + ".log";
    const std::string command = BinFolder() + "/keypose run -C " + folder.string() + " --until " +
                                until + " > " + log.string() + " 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << ReadFile(log);
    fs::remove(log);
  }
  Answer Ask(const Question& question) {
    if (!routes_) routes_ = std::make_unique<Routes>(folder_);
    return routes_->Handle(question);
  }
  json Picks() { return Got("/api/landmarks"); }
  json Fit() { return Got("/api/landmarks/photographs"); }
  json Got(const std::string& path) {
    const Answer answer = Ask({"GET", path, {{"pose", "wave"}}, ""});
    EXPECT_EQ(answer.status, 200) << answer.bytes;
    return json::parse(answer.bytes);
  }
  int Put(const json& pixels) { return Put(pixels, RevisionOf(File())); }
  int Put(const json& pixels, const std::string& revision) {
    const json body = {{"pixels", pixels}, {"revision", revision}};
    return Ask({"PUT", "/api/landmarks", {{"pose", "wave"}}, body.dump()}).status;
  }
  /// Picks on the mesh of the template.
  Answer PutOnMesh(const json& picks, const fs::path& file) {
    const json body = {{"picks", picks}, {"revision", RevisionOf(file)}};
    return Ask({"PUT", "/api/landmarks", {{"pose", "rest"}}, body.dump()});
  }
  static json MeshPick(const std::string& name) {
    return {{"name", name}, {"face", 3}, {"barycentric", {0.2, 0.3, 0.5}}};
  }
  static json Pick(const std::string& name, const std::string& image, double x, double y) {
    return {{"name", name}, {"image", image}, {"pixel", {x, y}}};
  }
  fs::path File() const { return folder_ / "landmarks/wave.json"; }
  /// By another program, which is asked again what it is.
  void Replace(const std::string& stage) const {
    WriteFile(folder_ / "tools" / stage, std::string(kCopy) + "# another one\n");
    fs::permissions(folder_ / "tools" / stage, fs::perms::owner_all);
  }
  /// Regions on the template's mesh.
  fs::path Painted() const { return folder_ / "regions.json"; }
  json Regions() { return json::parse(Ask({"GET", "/api/regions", {}, ""}).bytes)["regions"]; }
  Answer Paint(const json& regions) {
    const json body = {{"regions", regions}, {"revision", RevisionOf(Painted())}};
    return Ask({"PUT", "/api/regions", {}, body.dump()});
  }

  static inline std::unique_ptr<TestingFolder> own_made;
  static inline fs::path made;
  static inline const Mesh mesh = MakeIcosphere(2);
  static inline Scene scene;
  const TestingFolder own_;
  const fs::path place_ = own_.path(), folder_ = place_ / "dance";
  std::unique_ptr<Routes> routes_;
};

TEST_F(PhotoPicks, AreSavedAsThePipelineReadsThemAndGoWithTheLast) {
  EXPECT_EQ(Picks().at("pixels"), json::array());
  const json two = {Pick("nose", "a_0.png", 12.5, 40), Pick("nose", "a_40.png", 8, 300)};
  ASSERT_EQ(Put(two), 200);
  json written = json::parse(ReadFile(File()));
  EXPECT_EQ(Picks().at("pixels"), written.at("pixels"));
  for (json& pick : written["pixels"]) EXPECT_EQ(pick.erase("photograph"), 1u);
  EXPECT_EQ(written, json({{"schema", 2}, {"pixels", two}}));
  EXPECT_EQ(Picks().at("problems"), json::array());
  ASSERT_EQ(Put(json::array()), 200);
  EXPECT_FALSE(fs::exists(File()));
}

TEST_F(PhotoPicks, OfAPhotographThatWasShotAgainAreToldAndMayStillHold) {
  const auto now = [&](const char* what) { return Fit().at("photographs")[0].at(what); };
  const json old = {Pick("nose", "a_0.png", 12, 40), Pick("ear", "a_40.png", 5, 6)};
  ASSERT_EQ(Put(old), 200);
  json noted = Picks().at("pixels");
  EXPECT_EQ(noted[0].at("photograph"), now("photograph"));
  for (const char* place : {"photos/wave", "tools/made_images"})
    WriteImage(folder_ / place / "a_0.png", Image8(kWidth, kHeight, 3, 50));
  EXPECT_EQ(now("shot_again"), true);
  EXPECT_EQ(Got("/api/photos")[0].at("captured"), false) << "the brush shows the new one";
  EXPECT_EQ(Got("/api/photos")[1].at("captured"), true);
  Run(folder_, "capture");
  routes_.reset();
  EXPECT_EQ(now("shot_again"), false);
  EXPECT_THAT(Picks().at("problems")[0].at("text").get<std::string>(), HasSubstr("older photog"));
  ASSERT_EQ(Put({old[0], old[1], Pick("toe", "a_80.png", 1, 2)}), 200);
  EXPECT_EQ(Picks().at("pixels")[0], noted[0]) << "an edit elsewhere is no word on this one";
  noted[0]["photograph"] = now("photograph");
  ASSERT_EQ(Put(noted), 200);
  EXPECT_EQ(Picks().at("problems"), json::array());
}

TEST_F(PhotoPicks, WhatThePageDoesNotShowStays) {
  WriteFile(File(), R"({"landmarks": [{"name": "toe", "position": [1, 2, 3]}], "pixels": [
      {"name": "nose", "image": "a_0.png", "pixel": [1, 2], "vertex": 7, "remark": "sharp"}]})");
  ASSERT_EQ(Put({Pick("snout", "a_0.png", 1, 2), Pick("ear", "a_40.png", 3, 4)}), 200);
  const json now = json::parse(ReadFile(File()));
  EXPECT_EQ(now.at("landmarks")[0].at("name"), "toe");
  EXPECT_EQ(now.at("pixels")[0].at("remark"), "sharp");
  EXPECT_EQ(now.at("pixels")[0].at("vertex"), 7);
  EXPECT_EQ(now.at("pixels")[0].at("name"), "snout");
  EXPECT_FALSE(now.at("pixels")[1].contains("vertex"));
  ASSERT_EQ(Put(json::array()), 200);
  EXPECT_TRUE(json::parse(ReadFile(File())).contains("landmarks"));
}

TEST_F(PhotoPicks, WhatWasChangedMeanwhileIsNotWrittenOver) {
  ASSERT_EQ(Put(json::array({Pick("nose", "a_0.png", 1, 2)})), 200);
  const std::string before = ReadFile(File());
  EXPECT_EQ(Put(json::array({Pick("ear", "a_0.png", 1, 2)}), "0000000000000000"), 409);
  EXPECT_EQ(ReadFile(File()), before);
}

TEST_F(PhotoPicks, NonsenseIsRefusedAndNothingIsWritten) {
  const std::vector<json> wrong = {
      Pick("", "a_0.png", 1, 2),
      Pick(std::string(300, 'a'), "a_0.png", 1, 2),
      Pick("nose", "b.png", 1, 2),
      Pick("nose", "../wave/a_0.png", 1, 2),
      Pick("nose", "a_0.png", -1, 2),
      Pick("nose", "a_0.png", 1, kHeight + 1),
      3,
      {{"name", "nose"}, {"image", "a_0.png"}, {"pixel", json::array({1})}},
      {{"name", "nose"}, {"image", "a_0.png"}, {"pixel", {"1", 2}}},
      {{"name", 3}, {"image", "a_0.png"}, {"pixel", {1, 2}}}};
  for (const json& pick : wrong) EXPECT_EQ(Put(json::array({pick}), ""), 400) << pick;
  EXPECT_EQ(Put({Pick("nose", "a_0.png", 1, 2), Pick("nose", "a_0.png", 3, 4)}, ""), 400);
  EXPECT_EQ(Put(json("x"), ""), 400);
  EXPECT_FALSE(fs::exists(File()));
  EXPECT_EQ(Ask({"GET", "/api/landmarks/photographs", {{"pose", "rest"}}, ""}).status, 400);
  EXPECT_EQ(Ask({"GET", "/api/landmarks/photographs", {{"pose", "../x"}}, ""}).status, 400);
}

TEST_F(PhotoPicks, AFileThatCannotBeReadIsNamedAndNotLost) {
  for (const std::string& text :
       {std::string("{\"pixels\": ["), std::string("7"), std::string("{\"pixels\": 3}"),
        std::string(R"({"pixels": [{"name": "nose", "image": "a_0.png"}]})")}) {
    WriteFile(File(), text);
    EXPECT_THAT(Picks().at("problems")[0].at("text").get<std::string>(), HasSubstr("wave.json"));
    EXPECT_EQ(Put(json::array({Pick("ear", "a_0.png", 1, 2)})), 400) << text;
    EXPECT_EQ(ReadFile(File()), text);
  }
  WriteFile(File(), json{{"pixels", json::array({Pick("nose", "gone.png", 1, 2)})}}.dump());
  EXPECT_THAT(Picks().at("problems")[0].at("text").get<std::string>(), HasSubstr("gone.png"));
  EXPECT_EQ(Put({Pick("nose", "gone.png", 1, 2), Pick("ear", "a_0.png", 1, 2)}), 200) << "it stays";
}

TEST_F(PhotoPicks, TheFileThatPipelineYamlNamesIsUsedUnlessItIsOutside) {
  WriteFile(folder_ / "mine.json", "{}");
  Project(", landmarks: mine.json");
  ASSERT_EQ(Put(json::array({Pick("nose", "a_0.png", 1, 2)}), RevisionOf(folder_ / "mine.json")),
            200);
  EXPECT_THAT(ReadFile(folder_ / "mine.json"), HasSubstr("nose"));
  EXPECT_FALSE(fs::exists(File()));
  WriteFile(place_ / "outside/picks.json", "{}");
  fs::create_symlink(place_ / "outside", folder_ / "link");
  for (const char* file : {"../outside/picks.json", "link/picks.json"}) {
    Project(std::string(", landmarks: ") + file);
    EXPECT_THAT(Picks().at("problems")[0].at("text").get<std::string>(), HasSubstr("outside"));
    const std::string revision = RevisionOf(place_ / "outside/picks.json");
    EXPECT_EQ(Put(json::array({Pick("nose", "a_0.png", 1, 2)}), revision), 400);
    EXPECT_EQ(ReadFile(place_ / "outside/picks.json"), "{}");
  }
}

TEST_F(PhotoPicks, TheLastOneTakesItsFileOutOfPipelineYaml) {
  WriteFile(folder_ / "mine.json",
            json{{"pixels", json::array({Pick("nose", "a_0.png", 1, 2)})}}.dump());
  Project(", landmarks: mine.json");
  ASSERT_EQ(Put(json::array(), RevisionOf(folder_ / "mine.json")), 200);
  EXPECT_FALSE(fs::exists(folder_ / "mine.json"));
  EXPECT_EQ(Text(), ProjectText("")) << "a project must not name a file that is gone";
}

TEST_F(PhotoPicks, OnTheMeshAreSavedInTheFileThatPipelineYamlNames) {
  Run(folder_, "unwrap");
  const fs::path mine = folder_ / "mine.json";
  for (const char* rest :
       {"{photos: photos/rest, landmarks: mine.json}", "{landmarks: mine.json}"}) {
    Project("", rest);
    WriteLandmarks(mine, mesh, {Landmark{"nose", 0, {0.2, 0.3, 0.5}}});
    const Answer answer = PutOnMesh(json::array({MeshPick("ear")}), mine);
    ASSERT_EQ(answer.status, 200) << answer.bytes;
    EXPECT_EQ(json::parse(answer.bytes).at("picks")[0].at("name"), "ear");
    EXPECT_THAT(ReadFile(mine), HasSubstr("ear"));
    EXPECT_FALSE(fs::exists(folder_ / "landmarks/rest.json"));
    ASSERT_EQ(PutOnMesh(json::array(), mine).status, 200);
    EXPECT_FALSE(fs::exists(mine));
    EXPECT_THAT(Text(), Not(HasSubstr("mine.json")));
    EXPECT_THAT(Text(), HasSubstr("photos/rest"));
  }
  WriteFile(folder_ / "points.pp", PickedPointsText({Landmark{"nose", 0, {1, 0, 0}}}, mesh));
  Project("", "{landmarks: points.pp}");
  const Answer answer = PutOnMesh(json::array({MeshPick("ear")}), folder_ / "points.pp");
  EXPECT_EQ(answer.status, 400);
  EXPECT_THAT(answer.bytes, HasSubstr("names points.pp"));
  EXPECT_THAT(ReadFile(folder_ / "points.pp"), HasSubstr("nose"));
}

TEST_F(PhotoPicks, OnTheMeshThatCannotBeReadAreNamedAndNotLost) {
  Run(folder_, "unwrap");
  const fs::path file = folder_ / "landmarks/rest.json";
  for (const std::string& text :
       {std::string("{\"landmarks\": ["), std::string(R"({"landmarks": [{"name": "nose"}]})")}) {
    WriteFile(file, text);
    const Answer answer = PutOnMesh(json::array({MeshPick("ear")}), file);
    EXPECT_EQ(answer.status, 400) << text;
    EXPECT_THAT(answer.bytes, HasSubstr("mend or delete it")) << text;
    EXPECT_EQ(ReadFile(file), text);
  }
}

TEST_F(PhotoPicks, BeforeAFitOnlyPhotographsAreKnown) {
  const json fit = Fit();
  ASSERT_EQ(fit.at("photographs").size(), 3u);
  EXPECT_EQ(fit.at("photographs")[0].at("width"), kWidth);
  EXPECT_EQ(fit.at("photographs")[0].at("placed"), false);
  for (const char* what : {"shown", "lines", "meets", "refused"}) EXPECT_TRUE(fit.at(what).empty());
}

TEST_F(PhotoPicks, AFitSaysWherePicksAreAndWhereOthersMustBe) {
  Run(folder_, "fit");
  const Landmark nose{"nose", 0, {0.2, 0.3, 0.5}};
  WriteLandmarks(folder_ / "landmarks/rest.json", mesh, {nose});
  const Eigen::Vector3d x = PositionOf(nose, mesh);
  const auto pixel_in = [&](int view) { return Eigen::Vector2d(scene.views[view].Project(x)); };
  const auto pick_in = [&](int view) {
    return Pick("nose", scene.views[view].name, pixel_in(view).x(), pixel_in(view).y());
  };
  ASSERT_EQ(Put(json::array({pick_in(0)})), 200);
  json fit = Fit();
  ASSERT_EQ(fit.at("shown").size(), 3u);
  for (const json& shown : fit.at("shown"))
    for (int v = 0; v < 3; ++v)
      for (int k = 0; k < 2 && shown.at("image") == scene.views[v].name; ++k)
        EXPECT_NEAR(shown.at("pixel")[k].get<double>(), pixel_in(v)[k], 0.01);
  ASSERT_EQ(fit.at("lines").size(), 2u);
  EXPECT_TRUE(fit.at("meets").empty());
  double nearest = 1e9;
  const json& points = fit.at("lines")[0].at("points");
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Eigen::Vector2d a(points[i - 1][0], points[i - 1][1]), b(points[i][0], points[i][1]);
    const double t = std::clamp((pixel_in(1) - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (pixel_in(1) - a - t * (b - a)).norm());
  }
  EXPECT_LT(nearest, 0.1);
  EXPECT_EQ(fit.at("photographs")[1].at("worst").at("distance_px"), 7);
  EXPECT_TRUE(fit.at("photographs")[0].at("worst").is_null());
  EXPECT_EQ(fit.at("refused"), json::parse(R"([{"name": "nose", "image": "a_0.png"}])"));
  ASSERT_EQ(Put({pick_in(0), pick_in(1)}), 200);
  fit = Fit();
  EXPECT_TRUE(fit.at("lines").empty());
  ASSERT_EQ(fit.at("meets").size(), 3u);
  for (int k = 0; k < 2; ++k)
    EXPECT_NEAR(fit.at("meets")[2].at("pixel")[k].get<double>(), pixel_in(2)[k], 0.05);
}

TEST_F(PhotoPicks, PaintedRegionsFollowATemplateThatIsMadeAnew) {
  Run(folder_, "unwrap");
  ASSERT_EQ(Paint({{"foot", {0, 1, 2}}}).status, 200);
  EXPECT_EQ(Regions(), json({{"foot", {0, 1, 2}}}));
  routes_.reset();
  Mesh turned = mesh;  // the same vertices, the last one first
  const int last = mesh.vertex_count() - 1;
  turned.points = mesh.points.colwise().reverse();
  turned.faces = last - mesh.faces.array();
  WriteMesh(folder_ / "turned.ply", turned);
  fs::rename(folder_ / "turned.ply", folder_ / "tools/made_unwrapped");
  std::string description = ReadFile(folder_ / "tools/unwrap.json");
  description.replace(description.find(R"("version":"1")"), 13, R"("version":"2")");
  WriteFile(folder_ / "tools/unwrap.json", description);
  Replace("unwrap");
  Run(folder_, "unwrap");
  EXPECT_EQ(Regions(), json({{"foot", {last - 2, last - 1, last}}}));
}

TEST_F(PhotoPicks, RegionsThatAreBallsOrCannotBeReadAreNotWrittenOver) {
  Run(folder_, "unwrap");
  WriteRegions(Painted(), mesh, {{"head", {}, {0, 0, 1}, 0.2}, {"foot", {0, 1, 2}}});
  ASSERT_EQ(Paint({{"hand", {5}}}).status, 200);
  EXPECT_EQ(Regions(), json({{"hand", {5}}}));
  const std::string text = ReadFile(Painted());
  EXPECT_THAT(text, HasSubstr(R"("name":"head")"));
  EXPECT_THAT(text, HasSubstr(R"("radius":0.2)"));
  WriteFile(Painted(), text + "}");
  EXPECT_EQ(Ask({"GET", "/api/regions", {}, ""}).status, 400);
  const Answer refused = Paint({{"foot", {0}}});
  EXPECT_EQ(refused.status, 400);
  EXPECT_THAT(refused.bytes, HasSubstr("move regions.json away"));
  EXPECT_EQ(ReadFile(Painted()), text + "}");
}

TEST_F(PhotoPicks, AStageThatWasReplacedIsDescribedOnceAsItIsNow) {
  const auto summaries = [&] {
    std::vector<std::string> found;
    for (const json& stage : json::parse(Ask({"GET", "/api/stages", {}, ""}).bytes))
      if (stage["stage"] == "fit") found.push_back(stage["summary"]);
    return found;
  };
  EXPECT_EQ(summaries(), std::vector<std::string>{"copies"});
  std::string description = ReadFile(folder_ / "tools/fit.json");
  description.replace(description.find("copies"), 6, "bends");
  WriteFile(folder_ / "tools/fit.json", description);
  Replace("fit");
  EXPECT_EQ(summaries(), std::vector<std::string>{"bends"});
}

TEST_F(PhotoPicks, TabsThatAskForSuggestionsAtOnceGetTheirOwn) {
  Run(folder_, "unwrap");
  constexpr int kTabs = 4;
  std::vector<Answer> answers(kTabs);
  const auto ask = [&](int count) {
    answers[count] = Ask({"POST",
                          "/api/landmarks/suggest",
                          {},
                          json{{"pose", "rest"}, {"count", count + 1}}.dump()});
  };
  Ask({"GET", "/api/project", {}, ""});
  std::vector<std::thread> tabs;
  for (int i = 0; i < kTabs; ++i) tabs.emplace_back(ask, i);
  for (std::thread& tab : tabs) tab.join();
  for (int i = 0; i < kTabs; ++i) {
    ASSERT_EQ(answers[i].status, 200) << answers[i].bytes;
    const json told = json::parse(answers[i].bytes);
    EXPECT_EQ(told["pairs"].size(), i + 1u);
    EXPECT_EQ(told["why_none"], "");
  }
  for (const auto& entry : fs::directory_iterator(folder_ / ".keypose/studio"))
    EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr("suggested")));
}

}  // namespace keypose::studio::landmarks_routes_test
