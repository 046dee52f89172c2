// Two runs beside each other, over the routes: what was before is what the cache still has, and
// what was said of a result belongs to its content.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "studio/routes/routes.h"

namespace keypose::studio::review_routes_test {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kCube[] = R"(v -1 -1 -1
v 1 -1 -1
v 1 1 -1
v -1 1 -1
v -1 -1 1
v 1 -1 1
v 1 1 1
v -1 1 1
f 1 4 3
f 1 3 2
f 5 6 7
f 5 7 8
f 1 2 6
f 1 6 5
f 2 3 7
f 2 7 6
f 3 4 8
f 3 8 7
f 4 1 5
f 4 5 8
)";

/// A stage as a script: its folder in $here, what it makes in $to, its report's path in $report.
std::string Script(const std::string& name, const std::string& output, const std::string& act) {
  return "#!/bin/sh\nhere=$(dirname \"$(readlink -f \"$0\")\")\n"
         "if [ \"$1\" = --describe ]; then cat \"$here/" +
         name + ".json\"; exit; fi\nwhile [ $# -gt 1 ]; do\ncase \"$1\" in --" + output +
         ") to=$2 ;; --report) report=$2 ;; --size) size=$2 ;; --paint) paint=$2 ;; --clean) "
         "clean=$2 ;; esac\nshift 2\ndone\n" +
         act;
}

constexpr char kUnwrap[] =
    R"(awk -v s="$size" '$1 == "v" { print "v", $2 * s, $3 * s, $4 * s; next } { print }' "$clean" > "$to"
echo "{\"schema\": 1, \"measurements\": {\"size\": $size, \"faces\": 12, \"cpu_seconds\": $$, \"depth\": $size}}" > "$report"
)";
constexpr char kPipeline[] = R"(poses: {rest: photos/rest}
steps:
  capture: {enabled: false}
  sfm: {enabled: false}
  masks: {enabled: false}
  dense: {enabled: false}
  mesh: {enabled: false}
  refine: {enabled: false}
  cleanup: {enabled: false}
  register: {enabled: false}
  fit: {enabled: false}
  complete: {enabled: false}
  interpolate: {enabled: false}
  export: {enabled: false}
  report: {enabled: false}
  unwrap: {program: tools/unwrap, inputs: {clean: ./cube.obj}}
  bake: {program: tools/bake, inputs: {mesh: unwrap.unwrapped, images: null, model: null}, out: {texture: "{pose}/swatch.png"}}
  film: {program: tools/film, for: project, inputs: {mesh: unwrap.unwrapped@template}, out: {animation: animation}}
)";

class ReviewRoutes : public ::testing::Test {
 protected:
  ReviewRoutes() {
    fs::create_directories(folder_ / "photos/rest");
    WriteFile(folder_ / "cube.obj", kCube);
    AddStage("unwrap", "unwrapped", kUnwrap,
             R"("title": "Texture layout",
      "measurements": [{"key": "size", "label": "how large", "unit": "m", "good": {"max": 1.5}}],
      "inputs": [{"name": "clean", "kind": "file"}],
      "outputs": [{"name": "unwrapped", "kind": "file", "file": "unwrapped.obj"}],
      "options": [{"name": "size", "type": "double", "default": 1}])");
    AddStage("bake", "texture", "printf '\\211PNG%s' \"$paint\" > \"$to\"\n",
             R"("inputs": [{"name": "mesh", "kind": "file"},
                 {"name": "images", "kind": "folder", "optional": true},
                 {"name": "model", "kind": "folder", "optional": true}],
      "outputs": [{"name": "texture", "kind": "file", "file": "texture.png"}],
      "options": [{"name": "paint", "type": "string", "default": "red"}])");
    AddStage("film", "animation", "mkdir \"$to\"; echo moves > \"$to/character.mp4\"\n",
             R"("inputs": [{"name": "mesh", "kind": "file"}],
      "outputs": [{"name": "animation", "kind": "folder", "file": "animation"}])");
    Run("");
  }
  ~ReviewRoutes() override { routes_.reset(); }

  void AddStage(const std::string& name, const std::string& output, const std::string& act,
                const std::string& about) const {
    fs::create_directories(folder_ / "tools");
    const fs::path program = folder_ / "tools" / name;
    WriteFile(program, Script(name, output, act));
    fs::permissions(program, fs::perms::owner_all);
    WriteFile(program.string() + ".json",
              R"({"schema": 1, "stage": ")" + name + R"(", "version": "1", )" + about + "}");
  }
  void Keypose(const std::string& words) const {
    const std::string command = "'" + BinFolder() + "/keypose' " + words + " -C '" +
                                folder_.string() + "' > '" + (own_.path() / "log").string() +
                                "' 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << ReadFile(own_.path() / "log");
  }
  /// A run with these options.
  void Run(const std::string& options) {
    routes_.reset();
    WriteFile(folder_ / "pipeline.yaml",
              std::string(kPipeline) + (options.empty() ? "" : "options: {" + options + "}\n"));
    Keypose("run");
    routes_ = std::make_unique<Routes>(folder_);
  }
  Answer Ask(const std::string& path, std::map<std::string, std::string> query = {}) {
    return routes_->Handle({"GET", path, std::move(query), ""});
  }
  json Overview() {
    const Answer answer = Ask("/api/review");
    EXPECT_EQ(answer.status, 200) << answer.bytes;
    return json::parse(answer.bytes);
  }
  json Pose() { return Overview().at("subjects")[0]; }
  Answer Say(const json& pose, const std::string& version, const std::string& verdict,
             const std::string& note, const std::string& revision) {
    return routes_->Handle({"POST",
                            "/api/review",
                            {},
                            json{{"pose", pose},
                                 {"version", version},
                                 {"verdict", verdict},
                                 {"note", note},
                                 {"revision", revision}}
                                .dump()});
  }
  Answer Say(const std::string& verdict, const std::string& note) {
    const json now = Overview();
    return Say("rest", now["subjects"][0]["versions"][0]["id"], verdict, note, now["revision"]);
  }
  json Compared() {
    const json versions = Pose().at("versions");
    const Answer answer =
        Ask("/api/review/compare",
            {{"pose", "rest"}, {"before", versions[1].at("id")}, {"after", versions[0].at("id")}});
    EXPECT_EQ(answer.status, 200) << answer.bytes;
    return json::parse(answer.bytes);
  }

  const TestingFolder own_;
  const fs::path folder_ = own_.path() / "hero";
  std::unique_ptr<Routes> routes_;
};

TEST_F(ReviewRoutes, EachChangeIsAVersionAndWhatStaysIsNone) {
  json all = Overview();
  ASSERT_EQ(all.at("subjects").size(), 2u) << all.dump(1);
  EXPECT_EQ(all["subjects"][0].at("pose"), "rest");
  EXPECT_EQ(all["subjects"][1].at("pose"), "") << "the film";
  ASSERT_EQ(all["subjects"][0].at("versions").size(), 1u);
  EXPECT_EQ(all["subjects"][0]["versions"][0].at("now"), true);
  EXPECT_EQ(all["subjects"][1]["versions"][0].at("files"),
            json({{{"path", "animation/character.mp4"},
                   {"title", "film"},
                   {"film", true},
                   {"at", all["subjects"][1]["versions"][0]["files"][0]["at"]}}}));
  const std::string first = all["subjects"][0]["versions"][0]["id"];

  Run("");
  EXPECT_EQ(Pose().at("versions").size(), 1u) << "nothing was made anew";
  Run("unwrap: {size: 1.1}");
  all = Overview();
  ASSERT_EQ(all["subjects"][0]["versions"].size(), 2u);
  EXPECT_EQ(all["subjects"][0]["versions"][1]["id"], first);
  EXPECT_EQ(all["subjects"][0]["versions"][1]["now"], false);
  EXPECT_EQ(all["subjects"][1]["versions"].size(), 1u) << "the film has the same content";
  Run("");
  all = Overview();
  ASSERT_EQ(all["subjects"][0]["versions"].size(), 2u) << "back to the first";
  EXPECT_EQ(all["subjects"][0]["versions"][0]["id"], first);
}

TEST_F(ReviewRoutes, WhatWasChangedAndTheFiguresThatMovedAreTold) {
  Run("unwrap: {size: 1.75}");
  const json compared = Compared();
  EXPECT_EQ(compared.at("changes"),
            json::parse(R"([{"step": "unwrap/rest", "title": "Texture layout",
                             "text": "option size: 1 -> 1.75"}])"))
      << "bake runs again for the mesh alone, which is no change of its own";
  ASSERT_EQ(compared.at("figures").size(), 2u) << "neither faces, nor times: " << compared.dump(1);
  EXPECT_EQ(compared["figures"][0],
            json::parse(R"({"step": "unwrap/rest", "title": "Texture layout", "key": "size",
                            "label": "how large", "unit": "m", "before": 1, "after": 1.75,
                            "good": {"max": 1.5}, "main": true})"));
  EXPECT_EQ(compared["figures"][1]["key"], "depth");
  EXPECT_EQ(compared["figures"][1]["main"], false);
}

TEST_F(ReviewRoutes, BothMeshesAndTheirDistanceComeFromTheCache) {
  Run("unwrap: {size: 1.1}, bake: {paint: blue}");
  const json versions = Pose().at("versions");
  const auto ask = [&](const char* what, const json& at) {
    const Answer answer = Ask(std::string("/api/review/") + what, {{"at", at}});
    EXPECT_EQ(answer.status, 200) << answer.bytes;
    return answer;
  };
  float corner[2] = {};
  for (const int version : {0, 1})
    std::memcpy(&corner[version], ask("mesh", versions[version].at("mesh")).bytes.data() + 16,
                sizeof(float));
  EXPECT_FLOAT_EQ(corner[0], -1.1f);
  EXPECT_FLOAT_EQ(corner[1], -1.0f);
  EXPECT_EQ(ReadFile(ask("file", versions[0].at("texture")).file), "\x89PNGblue");
  EXPECT_EQ(ReadFile(ask("file", versions[1].at("texture")).file), "\x89PNGred");
  EXPECT_EQ(ask("file", versions[1].at("texture")).type, "image/png");

  const Answer distance =
      Ask("/api/review/distance", {{"at", versions[0].at("mesh")}, {"to", versions[1].at("mesh")}});
  ASSERT_EQ(distance.bytes.size(), 8 * sizeof(float));
  float values[8];
  std::memcpy(values, distance.bytes.data(), sizeof values);
  // A corner is 0.1 outside in each direction; the diagonal is 2 sqrt(3).
  for (const float value : values) EXPECT_NEAR(value, 0.05, 1e-6);

  const json& swatch = versions[1].at("files").at(0);
  EXPECT_EQ(swatch.at("path"), "rest/swatch.png");
  const Answer picture = ask("file", swatch.at("at"));
  EXPECT_EQ(ReadFile(picture.file), "\x89PNGred");
  EXPECT_EQ(picture.type, "image/png");
}

TEST_F(ReviewRoutes, NothingElseIsServed) {
  const auto status = [&](const std::string& at) {
    return Ask("/api/review/file", {{"at", at}}).status;
  };
  const std::string texture = Pose()["versions"][0]["texture"],
                    artifact = texture.substr(0, texture.find('/'));
  EXPECT_EQ(status(texture), 200);
  EXPECT_EQ(status(Pose()["versions"][0]["mesh"]), 404) << "neither a picture nor a film";
  for (const char* other : {"/manifest.json", "/../../../pipeline.yaml", "/", "", "/texture.png/."})
    EXPECT_EQ(status(artifact + other), 404) << other;
  EXPECT_EQ(status(std::string(64, '0') + "/texture.png"), 404);
  EXPECT_EQ(status("../cache/" + texture), 404);
  EXPECT_EQ(Ask("/api/review/mesh").status, 400);
}

TEST_F(ReviewRoutes, WhatWasListedIsFoundWhateverRunsNext) {
  const json listed = Pose()["versions"][0];
  // Not made yet: the plan is of neither result.
  WriteFile(folder_ / "pipeline.yaml",
            std::string(kPipeline) + "options: {unwrap: {size: 1.5}, bake: {paint: blue}}\n");
  Keypose("run --until unwrap");
  const json between = Pose()["versions"][0];
  EXPECT_NE(between["id"], listed["id"]);
  Keypose("run");
  for (const json& version : {listed, between})
    for (const char* what : {"mesh", "texture"})
      EXPECT_EQ(Ask(what == std::string("mesh") ? "/api/review/mesh" : "/api/review/file",
                    {{"at", version.at(what)}})
                    .status,
                200)
          << what;
}

TEST_F(ReviewRoutes, WhatWasSaidStaysAndIsOfAnEarlierResultOnceThatChanges) {
  ASSERT_EQ(Say("approved", "").status, 200);
  ASSERT_EQ(Say("sent back", "the ear is too large").status, 200);
  json said = Pose().at("reviews");
  ASSERT_EQ(said.size(), 2u);
  EXPECT_EQ(said[0].at("verdict"), "sent back") << "the newest first";
  EXPECT_EQ(said[0].at("note"), "the ear is too large");
  EXPECT_EQ(said[0].at("holds"), true);
  const std::string of = said[0].at("version");

  Run("unwrap: {size: 0.9}");
  said = Pose().at("reviews");
  EXPECT_EQ(said[0].at("holds"), false);
  EXPECT_EQ(said[0].at("version"), of) << "which can be looked at";
  ASSERT_EQ(Say("approved", "so it stays").status, 200);
  EXPECT_EQ(Pose()["reviews"][0]["holds"], true);
  // A stage of another version that makes the same leaves it.
  std::string about = ReadFile(folder_ / "tools/unwrap.json");
  about.replace(about.find("\"version\": \"1\""), 14, "\"version\": \"2\"");
  WriteFile(folder_ / "tools/unwrap.json", about);
  Run("unwrap: {size: 0.9}");
  EXPECT_EQ(Pose()["reviews"][0]["holds"], true) << "the same bytes were made";

  const json file = json::parse(ReadFile(folder_ / "reviews.json"));
  EXPECT_EQ(file.at("schema"), 1);
  ASSERT_EQ(file.at("reviews").size(), 3u);
  EXPECT_EQ(file["reviews"][2].at("pose"), "rest");
  EXPECT_EQ(file["reviews"][2].at("shown").size(), 2u) << "mesh and texture";
  EXPECT_EQ(file["reviews"][2].at("steps").at("unwrap").get<std::string>().size(), 64u);
  EXPECT_THAT(file["reviews"][2].at("when"), HasSubstr(" UTC"));
}

TEST_F(ReviewRoutes, CleanedAwayIsSaidAndCannotBeApproved) {
  ASSERT_EQ(Say("approved", "").status, 200);
  const std::string first = Pose()["versions"][0]["id"];
  Run("unwrap: {size: 2}");
  routes_.reset();
  Keypose("gc --keep-runs 1");
  routes_ = std::make_unique<Routes>(folder_);
  const json pose = Pose(), old = pose.at("versions").at(1);
  EXPECT_EQ(pose["versions"].size(), 2u) << "the record of the run is still there";
  EXPECT_THAT(old.at("gone"), ElementsAre("unwrap/rest", "bake/rest"));
  EXPECT_EQ(old.at("mesh"), "");
  EXPECT_EQ(pose["reviews"][0].at("holds"), false);
  EXPECT_EQ(pose["reviews"][0].at("version"), "") << "nothing of it is left";
  const json compared = Compared();
  EXPECT_TRUE(compared.at("changes").empty());
  EXPECT_THAT(compared.at("unknown"), ElementsAre("unwrap/rest", "bake/rest"));
  const json now = Overview();
  const Answer answer = Say("rest", old.at("id"), "approved", "", now["revision"]);
  EXPECT_EQ(answer.status, 400);
  EXPECT_THAT(answer.bytes, HasSubstr("nothing is left to look at"));
}

TEST_F(ReviewRoutes, TheFileOfSomebodyElseIsNotWrittenOver) {
  const json now = Overview();
  const std::string id = now["subjects"][0]["versions"][0]["id"];
  EXPECT_THAT(Say("sent back", " \n").bytes, HasSubstr("what is to be changed"));
  EXPECT_EQ(Say("fine", "").status, 400);
  EXPECT_FALSE(fs::exists(folder_ / "reviews.json"));
  ASSERT_EQ(Say("", "film").status, 400);
  ASSERT_EQ(Say("approved", "mine").status, 200);
  EXPECT_EQ(Say("rest", id, "approved", "late", now["revision"]).status, 409);
  json file = json::parse(ReadFile(folder_ / "reviews.json"));
  file["reviews"][0]["by"] = "Ann";
  WriteFile(folder_ / "reviews.json", file.dump());
  ASSERT_EQ(Say("approved", "again").status, 200);
  file = json::parse(ReadFile(folder_ / "reviews.json"));
  EXPECT_EQ(file["reviews"][0]["by"], "Ann") << "what we do not know stays";
  const auto remove = [&](int index) {
    const json body = {{"index", index}, {"revision", Overview()["revision"]}};
    return routes_->Handle({"POST", "/api/review/remove", {}, body.dump()}).status;
  };
  EXPECT_EQ(remove(2), 400);
  EXPECT_EQ(remove(0), 200);
  file = json::parse(ReadFile(folder_ / "reviews.json"));
  ASSERT_EQ(file["reviews"].size(), 1u);
  EXPECT_EQ(file["reviews"][0]["note"], "again");

  WriteFile(folder_ / "reviews.json", R"({"schema": 2, "reviews": []})");
  EXPECT_THAT(Overview().at("problem"), HasSubstr("reviews.json is not of schema 1"));
  EXPECT_EQ(Overview()["subjects"].size(), 2u) << "the results are shown all the same";
  EXPECT_EQ(Say("approved", "").status, 400);
  EXPECT_EQ(ReadFile(folder_ / "reviews.json"), R"({"schema": 2, "reviews": []})");
}

TEST_F(ReviewRoutes, APoseKeepsThemUnderItsNewName) {
  ASSERT_EQ(Say("approved", "good").status, 200);
  const json body = {{"pose", "rest"}, {"name", "asleep"}};
  const Answer answer = routes_->Handle({"POST", "/api/poses/rename", {}, body.dump()});
  ASSERT_EQ(answer.status, 200) << answer.bytes;
  const json pose = Pose();
  EXPECT_EQ(pose.at("pose"), "asleep");
  ASSERT_EQ(pose.at("reviews").size(), 1u);
  EXPECT_EQ(pose["reviews"][0]["holds"], true) << "the artifacts do not know the name";
}

}  // namespace keypose::studio::review_routes_test
