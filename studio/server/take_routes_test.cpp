// Requests of a take's page, with `keypose armature` behind them.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "pipeline/session.h"
#include "studio/runs/children.h"
#include "studio/server/routes.h"

namespace keypose::studio {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class TakeRoutes : public testing::Test {
 protected:
  TakeRoutes() : folder_(fs::temp_directory_path() / ("take_routes_" + std::to_string(getpid()))) {
    ::signal(SIGPIPE, SIG_IGN);
    fs::create_directories(folder_ / "armature");
    routes_ = std::make_unique<Routes>(folder_);
    // A smaller one than that of the route, which takes what is there.
    Program({"example", "--folder", (folder_ / "armature/example").string(), "--vertices", "3000"});
    setup_ = json::parse(Post("example", json::object()).bytes);
    setup_["mesh"] = setup_["set"] = "";  // ball and stick
    Record("walk");
    fs::create_directories(folder_ / ".keypose/studio");
    WriteFile(folder_ / ".keypose/studio/armature.json", setup_.dump());
  }
  ~TakeRoutes() override {
    routes_.reset();
    fs::remove_all(folder_);
  }

  void Program(std::vector<std::string> words) {
    words.insert(words.begin(), (pipeline::ProgramFolder() / "keypose-armature").string());
    const ChildResult made = RunChild(words, folder_, 60);
    ASSERT_EQ(made.exit_code, 0) << made.output;
  }
  void Record(const std::string& take) {
    Program({"record", "--description", (folder_ / "armature/example/theropod.txt").string(),
             "--port", "simulated", "--session", (folder_ / "armature" / take).string(), "--frames",
             "4", "--step", "2"});
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

  const fs::path folder_;
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

}  // namespace
}  // namespace keypose::studio
