// Requests of a take's page, with `keypose armature` behind them.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "pipeline/run/opened_project.h"
#include "studio/routes/routes.h"
#include "studio/runs/children.h"

namespace keypose::studio::take_routes_test {

namespace fs = std::filesystem;
using nlohmann::json;

class TakeRoutes : public ::testing::Test, public TestingFolder {
 protected:
  /// One project with a recorded take, which each test gets as a copy.
  static void SetUpTestSuite() {
    made = std::make_unique<TestingFolder>();
    const fs::path example = made->path() / "armature/example";
    fs::create_directories(example.parent_path());
    // A smaller one than that of the route, which takes what is there.
    Program({"example", "--folder", example.string(), "--vertices", "3000"});
    Program({"record", "--description", (example / "theropod.txt").string(), "--port", "simulated",
             "--session", (made->path() / "armature/walk").string(), "--frames", "4", "--step",
             "2"});
  }
  static void TearDownTestSuite() { made.reset(); }

  TakeRoutes() {
    ::signal(SIGPIPE, SIG_IGN);
    fs::copy(made->path(), folder_, fs::copy_options::recursive);
    routes_ = std::make_unique<Routes>(folder_);
    setup_ = json::parse(Post("example", json::object()).bytes);
    setup_["mesh"] = setup_["set"] = "";  // ball and stick
    fs::create_directories(folder_ / ".keypose/studio");
    WriteFile(folder_ / ".keypose/studio/armature.json", setup_.dump());
  }
  ~TakeRoutes() override { routes_.reset(); }

  static void Program(std::vector<std::string> words) {
    words.insert(words.begin(), (pipeline::ProgramFolder() / "keypose-armature").string());
    const ChildResult done = RunChild(words, made->path(), 60);
    ASSERT_EQ(done.exit_code, 0) << done.output;
  }
  Answer Post(const std::string& path, const json& body) {
    return routes_->Handle({"POST", "/api/armature/" + path, {}, body.dump()});
  }
  Answer Get(const std::string& path, std::map<std::string, std::string> query = {}) {
    return routes_->Handle({"GET", "/api/armature" + path, std::move(query), ""});
  }
  Answer Draft(const json& edits, const json& take = "walk") {
    return Post("take/draft", {{"take", take}, {"edits", edits}});
  }
  Answer Save(const json& name, const json& edits, const json& take = "walk") {
    return Post("take/save", {{"take", take}, {"name", name}, {"edits", edits}});
  }
  static json Told(const Answer& draft) {
    return json::parse(draft.bytes.substr(0, draft.bytes.find('\n')));
  }
  static double Value(const json& take, const std::string& name, int frame) {
    for (const json& joint : take["joints"])
      if (joint["name"] == name) return joint["values"][frame];
    ADD_FAILURE() << "no joint " << name;
    return 0;
  }
  static std::string Words(const Answer& answer) { return json::parse(answer.bytes)["error"]; }

  static inline std::unique_ptr<TestingFolder> made;
  std::unique_ptr<Routes> routes_;
  json setup_;
};

TEST_F(TakeRoutes, TakeIsOpenedChangedAndKeptAsANewOne) {
  const Answer opened = Post("take/open", {{"take", "walk"}});
  ASSERT_EQ(opened.status, 200) << opened.bytes;
  const json view = json::parse(opened.bytes)["view"];
  EXPECT_EQ(json::parse(opened.bytes)["set"], false);
  EXPECT_EQ(Get("/mesh", {{"take", "walk"}}).status, 200);
  EXPECT_EQ(Get("/weights", {{"take", "walk"}}).bytes.size(),
            24 * view["vertices"].get<std::size_t>());
  EXPECT_EQ(Get("/plate", {{"take", "walk"}, {"index", "0"}}).status, 200);
  EXPECT_EQ(Get("/weights").status, 404) << "no session has begun";

  const Answer plain = Draft(json::array());
  ASSERT_EQ(plain.status, 200) << plain.bytes;
  const std::size_t begin = plain.bytes.find('\n') + 1;
  EXPECT_EQ(begin % 4, 0u);
  EXPECT_EQ(plain.bytes.size() - begin, 4 * 28 * view["bones"].get<std::size_t>());
  const Answer pulled = Draft({"set leftKneeBend 2 -41.5", "step 1"});
  ASSERT_EQ(pulled.status, 200) << pulled.bytes;
  EXPECT_EQ(Told(pulled)["step"], 1);
  EXPECT_EQ(Value(Told(pulled), "leftKneeBend", 4), -41.5);
  EXPECT_EQ(Value(Told(pulled), "leftKneeBend", 2), Value(Told(plain), "leftKneeBend", 1));
  EXPECT_FALSE(fs::exists(folder_ / "armature/walk/edits.txt")) << "a draft is not kept";
  for (const auto& left : fs::directory_iterator(folder_ / ".keypose/studio/take-drafts"))
    EXPECT_EQ(left.path().filename(), "said.txt");

  const std::string before = ReadFile(folder_ / "armature/walk/curves.json");
  ASSERT_EQ(Save("walk_2", {"set leftKneeBend 2 -41.5"}).status, 200);
  EXPECT_EQ(ReadFile(folder_ / "armature/walk/curves.json"), before);
  EXPECT_EQ(ReadFile(folder_ / "armature/walk_2/edits.txt"),
            "set leftKneeBend 2 -41.5\n# of the take walk\n");
  const json story = json::parse(Get("").bytes);
  EXPECT_EQ(story["takes"], json({"walk"}));
  EXPECT_EQ(story["edited"], json({"walk_2"}));
  EXPECT_EQ(Value(Told(Draft(json::array(), "walk_2")), "leftKneeBend", 2), -41.5);
  EXPECT_EQ(Save("walk_2", {"step 1"}).status, 409) << "a take is never replaced";
}

TEST_F(TakeRoutes, ATakeIsWholeAfterItsProjectWasMoved) {
  ASSERT_EQ(Post("take/open", {{"take", "walk"}}).status, 200);
  routes_.reset();
  const fs::path elsewhere = folder_.string() + "_moved";
  fs::rename(folder_, elsewhere);
  routes_ = std::make_unique<Routes>(elsewhere);
  EXPECT_EQ(Post("take/open", {{"take", "walk"}}).status, 200);
  EXPECT_EQ(Get("/plate", {{"take", "walk"}, {"index", "0"}}).status, 200);
  routes_.reset();
  fs::rename(elsewhere, folder_);
}

TEST_F(TakeRoutes, ATakeOfTheCommandLineFindsItsPuppetByItself) {
  fs::remove_all(folder_ / ".keypose");
  EXPECT_EQ(json::parse(Get("").bytes)["takes"], json({"walk"}));
  const Answer opened = Post("take/open", {{"take", "walk"}});
  ASSERT_EQ(opened.status, 200) << opened.bytes;
  EXPECT_EQ(json::parse(opened.bytes)["set"], true) << "set.ply lies beside the description";
  const json setup = json::parse(Get("/take/setup", {{"take", "walk"}}).bytes);
  const std::string example = "armature/example/";
  EXPECT_EQ(setup["description"], example + "theropod.txt");
  EXPECT_EQ(setup["chains"], example + "theropod_chains.txt");
  EXPECT_EQ(setup["skeleton"], example + "theropod.bvh");
  EXPECT_EQ(setup["mesh"], example + "theropod.ply");
  EXPECT_EQ(setup["plate"], example + "plate.png");
  EXPECT_EQ(setup["shot"], example + "shot.json");
  EXPECT_EQ(setup["texture"], "");
  EXPECT_EQ(Draft({"set leftKneeBend 2 -41.5"}).status, 200);
  // Another choice is kept, and so is a take that is made from it.
  json sticks = setup;
  sticks["mesh"] = "";
  ASSERT_EQ(Post("take/open", {{"take", "walk"}, {"setup", sticks}}).status, 200);
  ASSERT_EQ(Save("walk_2", {"step 1"}).status, 200);
  EXPECT_EQ(json::parse(Get("/take/setup", {{"take", "walk_2"}}).bytes)["mesh"], "");
  const std::string upright = Draft(json::array()).bytes;
  sticks["skeleton_up"] = "y";
  ASSERT_EQ(Post("take/open", {{"take", "walk"}, {"setup", sticks}}).status, 200);
  EXPECT_NE(Draft(json::array()).bytes, upright) << "its skeleton has another way up";
}

TEST_F(TakeRoutes, FilesOfTheLastSessionComeFirstIfTheyFit) {
  ASSERT_EQ(Post("take/open", {{"take", "walk"}}).status, 200);
  EXPECT_EQ(json::parse(Get("/take/setup", {{"take", "walk"}}).bytes)["mesh"], "")
      << "as in the last session";
  fs::remove_all(folder_ / ".keypose/studio/takes");
  WriteFile(folder_ / "armature/leg.txt", "node {\n  name knee\n  axis 1 0 0\n  sensor 0\n}\n");
  setup_["description"] = "armature/leg.txt";
  WriteFile(folder_ / ".keypose/studio/armature.json", setup_.dump());
  ASSERT_EQ(Post("take/open", {{"take", "walk"}}).status, 200);
  EXPECT_EQ(json::parse(Get("/take/setup", {{"take", "walk"}}).bytes)["description"],
            "armature/example/theropod.txt");
}

TEST_F(TakeRoutes, ATakeWithoutItsPuppetSaysSoAndIsAskedForIt) {
  fs::remove_all(folder_ / ".keypose");
  fs::rename(folder_ / "armature/example/theropod.txt", folder_ / "armature/example/theropod.doc");
  const Answer opened = Post("take/open", {{"take", "walk"}});
  EXPECT_EQ(opened.status, 400);
  EXPECT_NE(Words(opened).find("no description below the folder 'armature' has the joints"),
            std::string::npos);
  EXPECT_EQ(Draft(json::array()).status, 400);
  json setup = setup_;
  setup["description"] = "armature/example/theropod.doc";
  ASSERT_EQ(Post("take/open", {{"take", "walk"}, {"setup", setup}}).status, 200);
  EXPECT_EQ(Draft(json::array()).status, 200);
  setup["description"] = "../theropod.txt";
  EXPECT_EQ(Post("take/open", {{"take", "walk"}, {"setup", setup}}).status, 404);
  EXPECT_EQ(Post("take/open", {{"take", "nobody"}, {"setup", setup_}}).status, 404);
  EXPECT_EQ(Post("take/open", {{"take", "walk"}, {"setup", 7}}).status, 400);
}

TEST_F(TakeRoutes, ADraftHasTheFilmThatABakeWouldMake) {
  const auto film = [&](const json& between) {
    return Post("take/draft", {{"take", "walk"}, {"edits", json::array()}, {"between", between}});
  };
  const Answer plain = Draft(json::array()), smooth = film("smooth");
  ASSERT_EQ(smooth.status, 200) << smooth.bytes;
  EXPECT_EQ(Told(plain)["film"], 0);
  EXPECT_EQ(Told(smooth)["film"], 7);
  const std::size_t one = (plain.bytes.size() - plain.bytes.find('\n') - 1) / 4;
  EXPECT_EQ(smooth.bytes.size() - smooth.bytes.find('\n') - 1,
            (4 + 7) * one + 7 * 4 * Told(smooth)["joints"].size());
  EXPECT_EQ(film("jumps").status, 400);
  EXPECT_EQ(film(7).status, 400);
}

class TakeUses : public TakeRoutes {
 protected:
  void Bake() {
    const std::string example = (folder_ / "armature/example/theropod").string();
    Program({"bake", "--description", example + ".txt", "--chains", example + "_chains.txt",
             "--curves", (folder_ / "armature/walk/curves.json").string(), "--frames",
             (folder_ / "armature/walk/frames").string()});
  }
  json Uses() { return json::parse(Get("/take/use", {{"take", "walk"}}).bytes); }
  Answer Use(const std::string& use, bool used, const json& revision) {
    return routes_->Handle(
        {"PUT",
         "/api/armature/take/use",
         {},
         json{{"take", "walk"}, {"use", use}, {"used", used}, {"revision", revision}}.dump()});
  }
  json Project() { return json::parse(routes_->Handle({"GET", "/api/project", {}, ""}).bytes); }
  std::vector<std::string> Steps() {
    std::vector<std::string> names;
    const Answer answer = routes_->Handle({"GET", "/api/steps", {}, ""});
    const json told = json::parse(answer.bytes);
    for (const json& step : told["steps"]) names.push_back(step["step"]);
    return names;
  }
  std::string Text() { return ReadFile(folder_ / "pipeline.yaml"); }
};

TEST_F(TakeUses, AFolderOfTakesBecomesAProjectAndStopsBeingOne) {
  json uses = Uses();
  EXPECT_EQ(uses["baked"], false);
  EXPECT_EQ(Use("export", true, "").status, 400) << "nothing is baked";
  Bake();
  uses = Uses();
  EXPECT_EQ(uses["baked"], true);
  EXPECT_EQ(uses["stale"], false);
  EXPECT_EQ(uses["revision"], "");
  const Answer put = Use("export", true, uses["revision"]);
  ASSERT_EQ(put.status, 200) << put.bytes;
  uses = json::parse(put.bytes);
  EXPECT_EQ(uses["uses"]["export"]["used"], true);
  EXPECT_EQ(uses["uses"]["export"]["step"], "export_walk");
  EXPECT_EQ(Project()["problem"], "") << Text();
  EXPECT_EQ(Project()["poses"], json::array());
  EXPECT_EQ(Steps(), std::vector<std::string>{"export_walk"}) << Text();
  EXPECT_NE(Text().find("frames: ./armature/walk/frames"), std::string::npos) << Text();
  EXPECT_NE(Text().find("fps: 24"), std::string::npos) << Text();
  EXPECT_EQ(Use("export", false, "another").status, 409);
  const json option = {{"step", "export_walk"},
                       {"option", "fps"},
                       {"pose", ""},
                       {"value", "12"},
                       {"revision", uses["revision"]}};
  ASSERT_EQ(routes_->Handle({"POST", "/api/options", {}, option.dump()}).status, 200);
  EXPECT_NE(Text().find("fps: 12"), std::string::npos) << Text();
  EXPECT_EQ(Use("export", false, Uses()["revision"]).status, 200);
  EXPECT_FALSE(fs::exists(folder_ / "pipeline.yaml")) << "its options go with the step";
  EXPECT_EQ(Project()["empty"], true);
}

TEST_F(TakeUses, AProjectKeepsItsTextAndGetsItBack) {
  Bake();
  fs::create_directories(folder_ / "photos/rest");
  const std::string before =
      "# Ann's dance.\nposes: {rest: photos/rest}  # one so far\nsteps:\n"
      "  unwrap: {enabled: true}  # as it is\n\n# the end\n";
  WriteFile(folder_ / "pipeline.yaml", before);
  for (const char* name : {"texture.png", "mesh.obj"}) WriteFile(folder_ / name, "");
  setup_.update({{"take", "walk"}, {"mesh", "mesh.obj"}, {"texture", "texture.png"}});
  fs::create_directories(folder_ / ".keypose/studio/takes");
  WriteFile(folder_ / ".keypose/studio/takes/walk.json", setup_.dump());
  for (const char* use : {"export", "composite"})
    ASSERT_EQ(Use(use, true, Uses()["revision"]).status, 200) << use;
  for (const char* kept : {"# Ann's dance.", "# one so far", "# as it is", "# the end"})
    EXPECT_NE(Text().find(kept), std::string::npos) << Text();
  for (const char* part : {"textures: ./texture.png", "shot: ./armature/example/shot.json",
                           "plate: ./armature/example/plate.png", "takes/walk_pictures"})
    EXPECT_NE(Text().find(part), std::string::npos) << Text();
  EXPECT_EQ(Project()["problem"], "") << Text();
  const std::vector<std::string> steps = Steps();
  EXPECT_EQ(std::count(steps.begin(), steps.end(), "composite_walk"), 1);
  for (const char* use : {"export", "composite"})
    ASSERT_EQ(Use(use, false, Uses()["revision"]).status, 200) << use;
  EXPECT_EQ(Text(), before);
}

TEST_F(TakeUses, WhatIsMissingIsSaid) {
  Bake();
  EXPECT_EQ(Uses()["uses"]["composite"]["lack"], "") << "a character of one colour will do";
  setup_.update({{"take", "walk"}, {"shot", ""}});
  fs::create_directories(folder_ / ".keypose/studio/takes");
  WriteFile(folder_ / ".keypose/studio/takes/walk.json", setup_.dump());
  EXPECT_EQ(Uses()["uses"]["composite"]["lack"], "the plate's camera");
  const Answer refused = Use("composite", true, "");
  EXPECT_EQ(refused.status, 400);
  EXPECT_NE(Words(refused).find("its files lack the plate"), std::string::npos);
  EXPECT_EQ(Use("frame", true, "").status, 400);
  EXPECT_FALSE(fs::exists(folder_ / "pipeline.yaml"));
  const auto later = fs::last_write_time(folder_ / "armature/walk/frames/frame_0000.ply");
  fs::last_write_time(folder_ / "armature/walk/curves.json", later + std::chrono::seconds(5));
  EXPECT_EQ(Uses()["stale"], true);
  WriteFile(folder_ / "pipeline.yaml", "poses: [");
  EXPECT_EQ(Get("/take/use", {{"take", "walk"}}).status, 400);
}

TEST_F(TakeRoutes, WhatAnEditCannotDoIsSaidInItsWords) {
  const Answer beyond = Draft({"hold all 0-1", "set leftKneeBend 2 30"});
  EXPECT_EQ(beyond.status, 400);
  EXPECT_EQ(Words(beyond),
            "line 2 of the edits: joint 'leftKneeBend' would be at 30 degrees in frame 2, and its "
            "limits are -150 to 0");
  const Answer nobody = Draft({"set leftKnee 2 30"});
  EXPECT_EQ(nobody.status, 400);
  EXPECT_EQ(Words(nobody).substr(0, 46), "edits.txt, line 1: no joint is called 'leftKne");
  EXPECT_EQ(Draft({"delete 0-3"}).status, 400);
  EXPECT_EQ(Save("walk_2", json::array()).status, 400) << "nothing was changed";
  EXPECT_EQ(Save("walk_2", {"delete 9"}).status, 400);
  EXPECT_FALSE(fs::exists(folder_ / "armature/walk_2"));
}

TEST_F(TakeRoutes, RecordingDoesNotGoOnWithAnEditedTake) {
  ASSERT_EQ(Save("walk_2", {"step 1"}).status, 200);
  setup_["take"] = "walk_2";
  const Answer start = Post("start", setup_);
  EXPECT_EQ(start.status, 400);
  EXPECT_NE(Words(start).find("edited"), std::string::npos);
}

TEST_F(TakeRoutes, CharacterIsMadeAgainOnlyWhenItsFilesChange) {
  ASSERT_EQ(Post("take/open", {{"take", "walk"}}).status, 200);
  const fs::path view = folder_ / ".keypose/studio/takes/walk/view.json";
  const auto first = fs::last_write_time(view);
  ASSERT_EQ(Post("take/open", {{"take", "walk"}}).status, 200);
  EXPECT_EQ(fs::last_write_time(view), first);
  const fs::path chains = folder_ / "armature/example/theropod_chains.txt";
  WriteFile(chains, ReadFile(chains) + "# another\n");
  ASSERT_EQ(Post("take/open", {{"take", "walk"}}).status, 200);
  EXPECT_NE(fs::last_write_time(view), first);
}

TEST_F(TakeRoutes, HostileRequestsAreRefused) {
  fs::create_directories(folder_ / "armature/link");
  fs::create_symlink("/etc/passwd", folder_ / "armature/link/curves.json");
  fs::create_directory_symlink("/tmp", folder_ / "armature/away");
  for (const json& take : {json("../walk"), json("walk/../walk"), json(""), json("-f"), json(7),
                           json(nullptr), json("example"), json("a b")}) {
    EXPECT_EQ(Post("take/open", {{"take", take}}).status, 400) << take;
    EXPECT_EQ(Draft({"step 1"}, take).status, 400) << take;
    EXPECT_EQ(Save("new", {"step 1"}, take).status, 400) << take;
    EXPECT_EQ(Save(take, {"step 1"}).status, 400) << take;
    EXPECT_EQ(Post("bake", {{"between", "hold"}, {"take", take}}).status, 400) << take;
  }
  for (const char* take : {"nobody", "link", "away"})
    for (const char* path : {"take/open", "take/draft", "take/save"})
      EXPECT_EQ(Post(path, {{"take", take}, {"name", "new"}, {"edits", {"step 1"}}}).status, 404)
          << path << " " << take;
  EXPECT_EQ(Save("away", {"step 1"}).status, 409);
  for (const char* path : {"/view", "/weights", "/mesh", "/plate", "/texture"})
    EXPECT_GE(Get(path, {{"take", "../../secret"}}).status, 400) << path;
  const std::string long_line(301, 'a');
  for (const json& edits : {json("step 1"), json(7), json(nullptr), json({7}), json({"a\nb"}),
                            json({long_line}), json({{"step 1"}}), json({"$(id)"}),
                            json({"--help"}), json(std::vector<std::string>(10001, "step 1"))})
    EXPECT_EQ(Draft(edits).status, 400) << edits.dump().substr(0, 60);
  EXPECT_EQ(Post("take/draft", {{"take", "walk"}}).status, 400);
  EXPECT_EQ(Post("take/draft", json::array()).status, 400);
  EXPECT_FALSE(fs::exists(folder_ / "armature/new"));
}

}  // namespace keypose::studio::take_routes_test
