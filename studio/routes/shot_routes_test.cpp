#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/pictures/render.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/camera.h"
#include "studio/project/snapshot.h"
#include "studio/routes/routes.h"

namespace keypose::studio::shot_routes_test {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr char kProject[] =
    "# by hand\nname: dance\nposes: {rest: photos/rest, wave: photos/wave}\ntemplate: rest\n";
constexpr char kShot[] =
    "shot:\n  film: films/take1  # on twos\n  fps: 12\n  shows: {0: rest, 4: wave}\n";

/// The template's mesh comes from the test; what else would make it is off.
constexpr char kUnwrapped[] = R"(options: {locate: {focal_35mm: 60}}
steps:
  capture: {enabled: false}
  sfm: {enabled: false}
  masks: {enabled: false}
  dense: {enabled: false}
  mesh: {enabled: false}
  refine: {enabled: false}
  cleanup: {enabled: false}
  unwrap: {program: tools/unwrap, inputs: {clean: ./ball.obj}}
  register: {inputs: {target: ./ball.obj}}
  bake: {enabled: false}
  complete: {enabled: false}
  locate: {inputs: {textures: null}}
  composite: {enabled: false}
  export: {enabled: false}
  report: {enabled: false}
)";

/// A stage whose output is its input.
constexpr char kUnwrap[] = R"sh(#!/bin/sh
if [ "$1" = --describe ]; then
  cat "$(readlink -f "$0").json"
  exit
fi
while [ $# -gt 1 ]; do
  case "$1" in
    --clean) clean="$2" ;;
    --unwrapped) unwrapped="$2" ;;
    --report) echo '{"schema": 1, "measurements": {}}' > "$2" ;;
  esac
  shift 2
done
cp "$clean" "$unwrapped"
)sh";

class ShotRoutes : public ::testing::Test {
 protected:
  ShotRoutes() {
    for (const char* folder : {"photos/rest", "photos/wave", "films/take1"})
      fs::create_directories(folder_ / folder);
    for (const char* name : {"a_0000.png", "a_0002.png", "a_0004.png"})
      WriteImage(folder_ / "films/take1" / name, Image8(64, 36, 3, 90));
    fs::create_directories(place_ / "outside");
    WriteImage(place_ / "outside/0000.png", Image8(8, 8, 3, 200));
    WriteImage(place_ / "outside/0001.png", Image8(8, 8, 3, 200));
  }
  ~ShotRoutes() override { routes_.reset(); }

  /// Asked anew: the watch would see the change only a moment later.
  void Project(const std::string& shot) {
    routes_.reset();
    WriteFile(folder_ / "pipeline.yaml", kProject + shot);
  }
  Answer Ask(const Question& question) {
    if (!routes_) routes_ = std::make_unique<Routes>(folder_);
    return routes_->Handle(question);
  }
  std::string Text() const { return ReadFile(folder_ / "pipeline.yaml"); }
  std::string Revision() const { return RevisionOf(folder_ / "pipeline.yaml"); }
  Answer Get(const std::string& path, const std::map<std::string, std::string>& query = {}) {
    return Ask({"GET", path, query, ""});
  }
  Answer Put(const std::string& path, const json& body) {
    return Ask({"PUT", path, {}, body.dump()});
  }
  /// One of each kind that may stand beside the film.
  void AddParts() {
    fs::create_directories(folder_ / "films/plates");
    for (const char* name : {"films/empty.png", "films/plates/0000.png", "films/plates/0001.png"})
      WriteImage(folder_ / name, Image8(64, 36, 3, 120));
    WriteFile(folder_ / "films/set.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    WriteFile(folder_ / "films/mattes.mov", std::string("\0\0\0\x14", 4) + "ftypqt  \0\0\0\0qt  ");
  }
  /// Runs until the template has a mesh.
  void AddTemplate() {
    fs::create_directories(folder_ / "tools");
    WriteMesh(folder_ / "ball.obj", ball_);
    const fs::path program = folder_ / "tools/unwrap";
    WriteFile(program, kUnwrap);
    fs::permissions(program, fs::perms::owner_all);
    const json input = {{"name", "clean"}, {"kind", "file"}};
    const json output = {{"name", "unwrapped"}, {"kind", "file"}, {"file", "unwrapped.obj"}};
    const json description = {{"schema", 1},
                              {"stage", "unwrap"},
                              {"version", "1"},
                              {"summary", "copies"},
                              {"inputs", json::array({input})},
                              {"outputs", json::array({output})},
                              {"options", json::array()}};
    WriteFile(program.string() + ".json", description.dump());
    const fs::path log = place_ / "log.txt";
    const std::string command = BinFolder() + "/keypose run -C " + folder_.string() +
                                " --until unwrap > " + log.string() + " 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << ReadFile(log);
  }
  static View Camera() {
    View view;
    view.camera.width = 64, view.camera.height = 36;
    view.camera.fx = view.camera.fy = 60.0 / 36 * 64;
    view.camera.cx = 32, view.camera.cy = 18;
    view.camera_from_world = LookAt({5, 4, 2}, Eigen::Vector3d::Zero());
    return view;
  }
  static json PixelOf(const Eigen::Vector2d& at) { return {at.x(), at.y()}; }
  json Changed(const json& parts) const {
    json change = NewShot("films/take1");
    change.update(parts);
    return change;
  }
  json Shot() { return json::parse(Get("/api/shot").bytes); }
  json NewShot(const std::string& film) const {
    return {{"film", film},
            {"fps", 12},
            {"shows", {{{"frame", 0}, {"pose", "rest"}}, {{"frame", 4}, {"pose", "wave"}}}},
            {"revision", Revision()}};
  }
  static json Click(double x) {
    return {{"name", "1"},
            {"frame", 4},
            {"pixel", {x, 7.5}},
            {"face", 3},
            {"barycentric", {0.2, 0.3, 0.5}}};
  }
  json Clicks(const json& clicks) const {
    return {{"clicks", clicks}, {"revision", RevisionOf(folder_ / "clicks.json")}};
  }

  const TestingFolder own_;
  const fs::path place_ = own_.path(), folder_ = place_ / "dance";
  const Mesh ball_ = MakeIcosphere(1);
  std::unique_ptr<Routes> routes_;
};

TEST_F(ShotRoutes, WhatMayBeAPartOfAShotIsOffered) {
  Project("");
  fs::create_directory_symlink(place_ / "outside", folder_ / "films/link");
  AddParts();
  WriteFile(folder_ / "photos/rest/scan.obj", "not for a shot");
  WriteFile(folder_ / "films/.hidden.mov", "hidden");
  const json shot = Shot();
  EXPECT_TRUE(shot.at("shot").is_null());
  EXPECT_EQ(shot.at("offers"), json::parse(R"({
      "folders": [{"path": "films/plates", "pictures": 2}, {"path": "films/take1", "pictures": 3}],
      "videos": ["films/mattes.mov"],
      "pictures": ["films/empty.png"],
      "meshes": ["films/set.obj"]})"));
}

TEST_F(ShotRoutes, ANewShotIsAddedBelowWhatIsThere) {
  Project("");
  const Answer answer = Put("/api/shot", NewShot("films/take1"));
  ASSERT_EQ(answer.status, 200) << answer.bytes;
  EXPECT_EQ(Text(), std::string(kProject) +
                        "shot:\n  film: films/take1\n  fps: 12\n  shows: {0: rest, 4: wave}\n");
  const json shot = json::parse(answer.bytes).at("shot");
  EXPECT_EQ(shot.at("width"), 64);
  EXPECT_EQ(shot.at("frames").at(1), json::parse(R"({"frame": 2, "name": "a_0002.png"})"));
}

TEST_F(ShotRoutes, AChangeKeepsCommentsAndOrder) {
  Project(kShot);
  json change = NewShot("films/take1");
  change["shows"].push_back({{"frame", 2}, {"pose", "wave"}});
  ASSERT_EQ(Put("/api/shot", change).status, 200);
  EXPECT_EQ(Text(), std::string(kProject) +
                        "shot:\n  film: films/take1  # on twos\n  fps: 12\n"
                        "  shows: {0: rest, 2: wave, 4: wave}\n");
}

TEST_F(ShotRoutes, WhatWasChangedMeanwhileIsNotWrittenOver) {
  Project(kShot);
  json change = NewShot("films/take1");
  Project(std::string(kShot) + "# more\n");
  EXPECT_EQ(Put("/api/shot", change).status, 409);
  EXPECT_THAT(Text(), HasSubstr("# more"));
}

TEST_F(ShotRoutes, AFilmOutsideOfTheProjectIsRefused) {
  Project("");
  fs::create_directory_symlink(place_ / "outside", folder_ / "films/link");
  for (const std::string& film :
       {(place_ / "outside").string(), std::string("../outside"), std::string("films/link"),
        std::string("films"), std::string("none"), std::string("films/take1/../../../outside")}) {
    const Answer answer = Put("/api/shot", NewShot(film));
    EXPECT_EQ(answer.status, 400) << film;
  }
  EXPECT_EQ(Text(), kProject);
}

TEST_F(ShotRoutes, NonsenseIsRefusedAndNothingIsWritten) {
  Project(kShot);
  const std::string before = Text();
  std::vector<json> changes;
  for (const json& shows :
       {json::parse(R"([])"), json::parse(R"([{"frame": 0, "pose": "rest"}])"),
        json::parse(R"([{"frame": 0, "pose": "x"}, {"frame": 1, "pose": "rest"}])"),
        json::parse(R"([{"frame": -1, "pose": "rest"}, {"frame": 1, "pose": "rest"}])"),
        json::parse(R"([{"frame": 0, "pose": "rest"}, {"frame": 0, "pose": "wave"}])")}) {
    changes.push_back(NewShot("films/take1"));
    changes.back()["shows"] = shows;
  }
  for (const json& fps : {json(0), json(-3), json("12"), json(7)}) {
    changes.push_back(NewShot("films/take1"));
    changes.back()["fps"] = fps;
  }
  for (const json& change : changes) EXPECT_EQ(Put("/api/shot", change).status, 400) << change;
  EXPECT_EQ(Text(), before);
}

TEST_F(ShotRoutes, PartsBesideTheFilmAreNamedAndTakenOutAgain) {
  Project(kShot);
  AddParts();
  const json parts = {{"plate", "films/plates"},
                      {"mattes", "films/mattes.mov"},
                      {"holdout", "films/empty.png"},
                      {"set", "films/set.obj"}};
  const Answer answer = Put("/api/shot", Changed(parts));
  ASSERT_EQ(answer.status, 200) << answer.bytes;
  EXPECT_EQ(Text(), std::string(kProject) + kShot +
                        "  plate: films/plates\n  mattes: films/mattes.mov\n"
                        "  holdout: films/empty.png\n  set: films/set.obj\n");
  const json shot = json::parse(answer.bytes).at("shot");
  for (const auto& [name, path] : parts.items()) EXPECT_EQ(shot.at(name), path) << name;
  // What a change does not speak of stays.
  ASSERT_EQ(Put("/api/shot", Changed({{"mattes", ""}, {"set", ""}})).status, 200);
  EXPECT_EQ(Text(),
            std::string(kProject) + kShot + "  plate: films/plates\n  holdout: films/empty.png\n");
}

TEST_F(ShotRoutes, ANewShotMayHaveAllParts) {
  Project("");
  AddParts();
  const Answer answer =
      Put("/api/shot",
          Changed({{"plate", "films/plates"}, {"set", "films/set.obj"}, {"camera", "moving"}}));
  ASSERT_EQ(answer.status, 200) << answer.bytes;
  EXPECT_EQ(Text(), std::string(kProject) +
                        "shot:\n  film: films/take1\n  fps: 12\n  shows: {0: rest, 4: wave}\n"
                        "  plate: films/plates\n  set: films/set.obj\n"
                        "options: {locate: {camera: moving}}\n");
  EXPECT_EQ(json::parse(answer.bytes).at("shot").at("camera"), "moving");
}

TEST_F(ShotRoutes, ACameraThatStandsAgainNeedsNoWord) {
  const std::string options = "options:\n  locate: {focal_35mm: 50}  # the lens\n";
  Project(kShot + options);
  EXPECT_EQ(Shot().at("shot").at("camera"), "still");
  ASSERT_EQ(Put("/api/shot", Changed({{"camera", "moving"}})).status, 200);
  EXPECT_THAT(Text(), HasSubstr("camera: moving"));
  EXPECT_THAT(Text(), HasSubstr("# the lens"));
  EXPECT_EQ(Shot().at("shot").at("camera"), "moving");
  ASSERT_EQ(Put("/api/shot", Changed({{"camera", "still"}})).status, 200);
  EXPECT_EQ(Text(), std::string(kProject) + kShot + options);
}

TEST_F(ShotRoutes, APartOfTheWrongKindOrPlaceIsRefused) {
  Project(kShot);
  AddParts();
  WriteFile(folder_ / "films/fake.mp4", "no film");
  fs::create_symlink(place_ / "outside/0000.png", folder_ / "films/link.png");
  for (const json& parts :
       {json{{"plate", "films/set.obj"}}, json{{"plate", "none.png"}}, json{{"plate", "films"}},
        json{{"mattes", "films/empty.png"}}, json{{"mattes", "films/fake.mp4"}},
        json{{"holdout", "films/plates"}}, json{{"set", "films/empty.png"}},
        json{{"set", "pipeline.yaml"}}, json{{"plate", (place_ / "outside/0000.png").string()}},
        json{{"plate", "../outside/0000.png"}}, json{{"holdout", "films/link.png"}},
        json{{"plate", 3}}, json{{"camera", "shaking"}}, json{{"camera", 1}}})
    EXPECT_EQ(Put("/api/shot", Changed(parts)).status, 400) << parts;
  EXPECT_EQ(Text(), std::string(kProject) + kShot);
}

TEST_F(ShotRoutes, AMovingCameraNeedsMoreThanOnePlate) {
  AddParts();
  Project(std::string(kShot) + "  plate: films/empty.png\n");
  const Answer answer = Put("/api/shot", Changed({{"camera", "moving"}}));
  EXPECT_EQ(answer.status, 400);
  EXPECT_THAT(answer.bytes, HasSubstr("one picture, but the camera moves"));
  const json both = {{"camera", "moving"}, {"plate", "films/plates"}};
  EXPECT_EQ(Put("/api/shot", Changed(both)).status, 200);
}

TEST_F(ShotRoutes, WhatAnEditorHasNamedOutsideOfTheProjectStays) {
  Project(std::string(kShot) + "  plate: ../outside  # of the rig\n");
  json change = NewShot("films/take1");
  change["plate"] = "../outside";
  change["shows"].push_back({{"frame", 2}, {"pose", "wave"}});
  ASSERT_EQ(Put("/api/shot", change).status, 200);
  EXPECT_THAT(Text(), HasSubstr("plate: ../outside  # of the rig"));
}

TEST_F(ShotRoutes, TheFirstClickMakesTheFileAndTheLastTakesItAway) {
  Project(kShot);
  Answer answer = Put("/api/shot/clicks", Clicks(json::array({Click(12)})));
  ASSERT_EQ(answer.status, 200) << answer.bytes;
  EXPECT_THAT(Text(), HasSubstr("clicks: clicks.json"));
  EXPECT_THAT(Text(), HasSubstr("# on twos"));
  EXPECT_EQ(json::parse(ReadFile(folder_ / "clicks.json")).at("clicks"), json::array({Click(12)}));
  EXPECT_EQ(json::parse(answer.bytes).at("clicks").at("clicks"), json::array({Click(12)}));
  ASSERT_EQ(Put("/api/shot/clicks", Clicks(json::array())).status, 200);
  EXPECT_FALSE(fs::exists(folder_ / "clicks.json"));
  EXPECT_EQ(Text(), std::string(kProject) + kShot);
}

TEST_F(ShotRoutes, ClicksOfAnEditorAreReadAndNotWrittenOver) {
  Project(std::string(kShot) + "  clicks: notes/mine.json\n");
  fs::create_directories(folder_ / "notes");
  WriteFile(folder_ / "notes/mine.json",
            R"({"clicks": [{"pixel": [3, 4], "vertex": 9, "remark": "nose"}]})");
  const json clicks = Shot().at("clicks");
  EXPECT_EQ(clicks.at("clicks"), json::parse(R"([{"frame": 0, "pixel": [3, 4], "vertex": 9}])"));
  EXPECT_EQ(Put("/api/shot/clicks", {{"clicks", json::array({Click(1)})}, {"revision", ""}}).status,
            409);
  EXPECT_THAT(ReadFile(folder_ / "notes/mine.json"), HasSubstr("nose"));
  ASSERT_EQ(Put("/api/shot/clicks",
                {{"clicks", json::array({Click(1)})}, {"revision", clicks.at("revision")}})
                .status,
            200);
  EXPECT_THAT(ReadFile(folder_ / "notes/mine.json"), HasSubstr("barycentric"));
  EXPECT_FALSE(fs::exists(folder_ / "clicks.json"));
}

TEST_F(ShotRoutes, ClicksThatCannotBeReadAreNamedAndNotLost) {
  Project(std::string(kShot) + "  clicks: clicks.json\n");
  for (const std::string& text :
       {std::string("{\"clicks\": ["), std::string("[]"), std::string("{\"clicks\": [7]}"),
        std::string(R"({"clicks": [{"pixel": [3, 4], "vertex": 9}, {"pixel": [3]}]})")}) {
    WriteFile(folder_ / "clicks.json", text);
    const json clicks = Shot().at("clicks");
    EXPECT_THAT(clicks.at("problem").get<std::string>(), HasSubstr("clicks.json")) << text;
    const Answer answer = Put("/api/shot/clicks", Clicks(json::array({Click(1)})));
    EXPECT_EQ(answer.status, 400) << text;
    EXPECT_THAT(answer.bytes, HasSubstr("mend or delete it")) << text;
    EXPECT_EQ(ReadFile(folder_ / "clicks.json"), text);
  }
}

TEST_F(ShotRoutes, ClicksOutsideOfTheProjectAreNeitherReadNorWritten) {
  WriteFile(place_ / "outside/clicks.json", R"({"clicks": []})");
  for (const char* file : {"../outside/clicks.json", "link/clicks.json"}) {
    Project(std::string(kShot) + "  clicks: " + file + "\n");
    std::error_code ignored;
    fs::create_directory_symlink(place_ / "outside", folder_ / "link", ignored);
    EXPECT_THAT(Shot().at("clicks").at("problem").get<std::string>(), HasSubstr("outside"));
    const json body = {{"clicks", json::array({Click(1)})},
                       {"revision", RevisionOf(place_ / "outside/clicks.json")}};
    EXPECT_EQ(Put("/api/shot/clicks", body).status, 400);
  }
  EXPECT_EQ(ReadFile(place_ / "outside/clicks.json"), R"({"clicks": []})");
}

TEST_F(ShotRoutes, AWrongClickIsRefused) {
  Project(kShot);
  std::vector<json> wrong(6, Click(3));
  wrong[0].erase("pixel");
  wrong[1]["pixel"] = {1, 2, 3};
  wrong[2]["face"] = -1;
  wrong[3]["barycentric"] = {1, 0};
  wrong[4]["frame"] = 0.5;
  wrong[5] = "click";
  for (const json& click : wrong)
    EXPECT_EQ(Put("/api/shot/clicks", Clicks(json::array({click}))).status, 400) << click;
  EXPECT_FALSE(fs::exists(folder_ / "clicks.json"));
  EXPECT_THAT(Text(), Not(HasSubstr("clicks")));
}

TEST_F(ShotRoutes, TheCameraOfAFrameIsAskedForByFourClicksOnAPosesMesh) {
  Project(kShot);
  const auto ask = [&](int frame) {
    return Ask({"POST", "/api/shot/quick", {}, json{{"frame", frame}}.dump()});
  };
  EXPECT_THAT(ask(2).bytes, HasSubstr("frame 2 shows no pose"));
  EXPECT_THAT(ask(4).bytes, HasSubstr("has no mesh yet"));
  EXPECT_EQ(Ask({"POST", "/api/shot/quick", {}, "{}"}).status, 400);
  Project(std::string(kShot) + kUnwrapped);
  AddTemplate();
  EXPECT_THAT(ask(0).bytes, HasSubstr("has 0 clicks; four are needed"));
}

TEST_F(ShotRoutes, FourClicksGiveTheCameraAtOnceAndItsOutlines) {
  Project(std::string(kShot) + kUnwrapped);
  AddTemplate();
  const View truth = Camera();
  json clicks = json::array();
  for (const int vertex : {0, 3, 5, 8, 11})
    clicks.push_back({{"frame", 0},
                      {"vertex", vertex},
                      {"pixel", PixelOf(truth.Project(ball_.points.row(vertex).transpose()))}});
  ASSERT_EQ(Put("/api/shot/clicks", Clicks(clicks)).status, 200);
  const std::string before = Text();
  const Answer answer = Ask({"POST", "/api/shot/quick", {}, R"({"frame": 0})"});
  ASSERT_EQ(answer.status, 200) << answer.bytes;
  const json found = json::parse(answer.bytes);
  EXPECT_EQ(found.at("problem"), "");
  EXPECT_NEAR(found.at("focal_px").get<double>(), truth.camera.fx, 1);
  EXPECT_TRUE(found.at("iou").is_null()) << "no mattes";
  const Answer picture =
      Get("/api/shot/picture", {{"what", "quick"}, {"number", found.at("number").dump()}});
  ASSERT_EQ(picture.status, 200);
  EXPECT_EQ(ReadImage(picture.file, 3).width, 64);
  EXPECT_EQ(Text(), before);
  // Clicks that cannot be true are told in words.
  clicks[1]["pixel"] = {60, 1};
  clicks[2]["pixel"] = {2, 33};
  ASSERT_EQ(Put("/api/shot/clicks", Clicks(clicks)).status, 200);
  const json wrong = json::parse(Ask({"POST", "/api/shot/quick", {}, R"({"frame": 0})"}).bytes);
  EXPECT_THAT(wrong.at("problem").get<std::string>(), StartsWith("the clicks do not agree"));
}

TEST_F(ShotRoutes, FramesAreGivenByTheirNumbersOnly) {
  Project(kShot);
  fs::create_symlink(place_ / "outside/0000.png", folder_ / "films/take1/a_0006.png");
  const Answer answer = Get("/api/shot/frame", {{"frame", "2"}});
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.file.filename(), "a_0002.png");
  EXPECT_EQ(Get("/api/shot/frame", {{"frame", "3"}}).status, 404);
  // A link that leads out of the film.
  EXPECT_EQ(Get("/api/shot/frame", {{"frame", "6"}}).status, 404);
  for (const char* frame : {"../../pipeline.yaml", "-1", "1e3", "", "0x2", "99999999999999999999"})
    EXPECT_EQ(Get("/api/shot/frame", {{"frame", frame}}).status, 400) << frame;
  for (const char* what :
       {"located", "quick", "plate", "result", "compare", "../../pipeline.yaml", ""})
    EXPECT_EQ(Get("/api/shot/picture", {{"what", what}}).status, 404) << what;
}

TEST_F(ShotRoutes, AFilmThatIsGoneIsSaidInWords) {
  Project(kShot);
  const json there = Shot();
  EXPECT_EQ(there.at("shot").at("problem"), "");
  EXPECT_TRUE(there.at("located").is_null());
  EXPECT_TRUE(there.at("finished").is_null());
  for (const char* name : {"a_0000.png", "a_0002.png", "a_0004.png"})
    fs::rename(folder_ / "films/take1" / name, folder_ / "films" / (std::string(name) + ".txt"));
  WriteFile(folder_ / "films/take1/readme.txt", "gone");
  EXPECT_NE(Shot().at("shot").at("problem"), "");
}

}  // namespace keypose::studio::shot_routes_test
