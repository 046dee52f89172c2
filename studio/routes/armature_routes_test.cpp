// The armature's requests, with `keypose armature live` on a simulated puppet behind them.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "pipeline/run/opened_project.h"
#include "studio/routes/routes.h"
#include "studio/runs/children.h"

namespace keypose::studio::armature_routes_test {

namespace fs = std::filesystem;
using nlohmann::json;

class ArmatureRoutes : public ::testing::Test, public TestingFolder {
 protected:
  /// A smaller one than that of the route, which takes what is there.
  static void SetUpTestSuite() {
    made = std::make_unique<TestingFolder>();
    const std::string program = (pipeline::ProgramFolder() / "keypose-armature").string();
    const ChildResult done = RunChild(
        {program, "example", "--folder", (made->path() / "example").string(), "--vertices", "3000"},
        made->path(), 60);
    ASSERT_EQ(done.exit_code, 0) << done.output;
  }
  static void TearDownTestSuite() { made.reset(); }

  ArmatureRoutes() {
    ::signal(SIGPIPE, SIG_IGN);
    routes_ = std::make_unique<Routes>(folder_);
  }
  ~ArmatureRoutes() override { routes_.reset(); }

  Answer Post(const std::string& path, const json& body) {
    return routes_->Handle({"POST", "/api/armature/" + path, {}, body.dump()});
  }
  Answer Get(const std::string& path, std::map<std::string, std::string> query = {}) {
    return routes_->Handle({"GET", "/api/armature" + path, std::move(query), ""});
  }
  json Story() { return json::parse(Get("").bytes); }
  json Example() {
    fs::create_directories(folder_ / "armature");
    fs::copy(made->path() / "example", folder_ / "armature/example");
    return MadeExample();
  }
  /// By the route itself.
  json MadeExample() { return json::parse(Post("example", json::object()).bytes); }
  /// Waits for at most half a minute.
  static bool Until(const std::function<bool()>& condition) {
    for (int i = 0; i < 600 && !condition(); ++i) usleep(50'000);
    return condition();
  }
  std::size_t Frames() { return Get("/frames").bytes.size(); }

  static inline std::unique_ptr<TestingFolder> made;
  std::unique_ptr<Routes> routes_;
};

TEST_F(ArmatureRoutes, SessionIsStartedFollowedAndEnded) {
  json setup = MadeExample();
  setup["mesh"] = setup["set"] = "";  // ball and stick
  ASSERT_EQ(Post("start", setup).status, 200);
  EXPECT_EQ(Post("start", setup).status, 409);
  ASSERT_TRUE(Until([&] { return Get("/pose").bytes != "null"; })) << Story();
  const json first = json::parse(Get("/pose").bytes);
  EXPECT_EQ(first["pose"]["values"].size(), 74u);
  EXPECT_EQ(Get("/mesh").status, 200);
  EXPECT_EQ(Get("/mesh", {{"what", "set"}}).status, 404);
  const Answer plate = Get("/plate", {{"index", "7"}});
  EXPECT_EQ(plate.status, 200);
  EXPECT_FALSE(plate.file.empty());
  EXPECT_EQ(Post("command", {{"command", "record"}}).status, 200);
  ASSERT_TRUE(Until([&] { return Frames() > 0; })) << Story();
  const std::size_t one = Frames();
  EXPECT_EQ(one, json::parse(Get("/view").bytes)["bones"].get<std::size_t>() * 28);
  EXPECT_EQ(Get("/frames", {{"from", std::to_string(one)}}).bytes, "");
  EXPECT_EQ(Post("command", {{"command", "end"}}).status, 200);
  ASSERT_TRUE(Until([&] { return !Story()["running"]; }));
  EXPECT_EQ(Story()["exit_code"], 0);
  EXPECT_EQ(Story()["takes"], json({"take1"}));
  EXPECT_EQ(Get("/pose").bytes, "null");
  EXPECT_EQ(Post("command", {{"command", "record"}}).status, 400);
  // What was recorded can be baked without a session.
  ASSERT_EQ(Post("bake", {{"between", "hold"}}).status, 200);
  ASSERT_TRUE(Until([&] { return !Story()["baking"]; }));
  EXPECT_TRUE(fs::exists(folder_ / "armature/take1/frames/frame_0001.ply"));
  EXPECT_FALSE(fs::exists(folder_ / "armature/take1/frames/frame_0002.ply"));
  // One pose is not enough for in-betweens, and the page is told so.
  std::string told;
  EventHub::Tab tab(routes_->hub());
  const Answer keys = Post("bake", {{"between", "keys"}});
  ASSERT_EQ(keys.status, 200) << keys.bytes;
  ASSERT_TRUE(Until([&] {
    told += tab.Next();
    return told.find("armature_baked") != std::string::npos;
  }));
  EXPECT_NE(told.find("one pose"), std::string::npos) << told;
}

TEST_F(ArmatureRoutes, ATakeKeepsItsPuppetWhenASessionWasBegunWithAnother) {
  json setup = Example();
  setup["mesh"] = setup["set"] = "";
  ASSERT_EQ(Post("start", setup).status, 200);
  ASSERT_TRUE(Until([&] { return Get("/pose").bytes != "null"; })) << Story();
  ASSERT_EQ(Post("command", {{"command", "record"}}).status, 200);
  ASSERT_TRUE(Until([&] { return Frames() > 0; })) << Story();
  ASSERT_EQ(Post("command", {{"command", "end"}}).status, 200);
  ASSERT_TRUE(Until([&] { return !Story()["running"]; }));
  WriteFile(folder_ / "armature/arm.txt",
            "node { name hip node { name upper length 1 node { name "
            "knee axis 1 0 0 sensor 0 node { name lower length 1 } } } }");
  WriteFile(folder_ / "armature/arm_chains.txt",
            "anchor a physical hip computer hip\n"
            "anchor b physical lower computer lower\nchain c from a to b\n");
  json other = setup;
  other["description"] = "armature/arm.txt";
  other["chains"] = "armature/arm_chains.txt";
  other["skeleton"] = other["plate"] = other["shot"] = "";
  ASSERT_EQ(Post("start", other).status, 200);
  ASSERT_TRUE(Until([&] { return !Story()["running"]; }));
  EXPECT_NE(Story()["message"].get<std::string>().find("the session has no joint 'knee'"),
            std::string::npos)
      << Story();
  const json kept = json::parse(Get("/take/setup", {{"take", "take1"}}).bytes);
  EXPECT_EQ(kept["description"], setup["description"]);
}

TEST_F(ArmatureRoutes, AStoryKeepsTheLastWordOnEachSubject) {
  json setup = Example();
  setup["mesh"] = setup["set"] = "";
  ASSERT_EQ(Post("start", setup).status, 200);
  const auto count = [&](const char* event) {
    int found = 0;
    const json story = Story();
    for (const json& told : story["events"]) found += told["event"] == event;
    return found;
  };
  ASSERT_TRUE(Until([&] { return count("session") == 1; })) << Story();
  for (const int plate : {0, 0, 0, 99999}) {
    const json command = {{"command", "plate"}, {"frame", plate}};
    EXPECT_EQ(Post("command", command).status, 200);
  }
  ASSERT_TRUE(Until([&] { return count("refused") == 1; })) << Story();
  EXPECT_EQ(count("plate"), 1);
  EXPECT_EQ(count("session"), 1) << "however many followed it";
  EXPECT_EQ(Post("command", {{"command", "end"}}).status, 200);
  ASSERT_TRUE(Until([&] { return !Story()["running"]; }));
}

TEST_F(ArmatureRoutes, BoardThatIsNotThereIsSaidInWords) {
  json setup = Example();
  setup["port"] = "/dev/no-such-board";
  ASSERT_EQ(Post("start", setup).status, 200);
  ASSERT_TRUE(Until([&] { return !Story()["running"]; }));
  EXPECT_NE(Story()["exit_code"], 0);
  // It has no calibration either, and says how one is made.
  EXPECT_NE(Story()["message"].get<std::string>().find("armature calibrate"), std::string::npos);
}

TEST_F(ArmatureRoutes, WhatLeadsOutOfTheProjectIsRefused) {
  const json good = Example();
  fs::create_symlink("/etc", folder_ / "armature/link");
  const auto status = [&](const char* field, const json& value) {
    json setup = good;
    setup[field] = value;
    return Post("start", setup).status;
  };
  for (const char* field : {"description", "chains", "skeleton", "mesh", "plate", "set", "shot"})
    for (const char* path : {"../secret", "/etc/passwd", "armature/link/passwd", "armature/none"})
      EXPECT_EQ(status(field, path), 404) << field << " " << path;
  EXPECT_EQ(status("description", ""), 400);
  EXPECT_EQ(status("description", 7), 400);
  for (const char* take : {"", "..", "a/b", "--faults", "example", "link"})
    EXPECT_EQ(status("take", take), 400) << take;
  for (const char* port : {"", "file", "/etc/passwd", "/dev/../etc/passwd"})
    EXPECT_EQ(status("port", port), 400) << port;
  EXPECT_EQ(status("skeleton_up", "x"), 400);
  EXPECT_EQ(status("fps", 0), 400);
  EXPECT_EQ(status("fps", "many"), 400);
  EXPECT_EQ(status("step", 1e9), 400);
  EXPECT_EQ(status("step", nullptr), 400);
  json board = good;
  board["port"] = "/dev/ttyACM0";
  board["calibration"] = "../puppet.json";
  EXPECT_EQ(Post("start", board).status, 400);
  EXPECT_FALSE(Story()["running"]);
}

TEST_F(ArmatureRoutes, CommandsAreKnownOnes) {
  for (const json& body :
       {json{{"command", "pictures"}}, json{{"command", "goto"}}, json{{"command", 5}},
        json{{"command", "goto"}, {"frame", -1}}, json{{"command", "zero"}, {"joint", "a\ncut"}},
        json{{"command", "zero"}, {"joint", ""}}, json::object(), json::array()})
    EXPECT_EQ(Post("command", body).status, 400) << body;
  EXPECT_EQ(Post("bake", {{"between", "hold"}}).status, 400);
  EXPECT_EQ(Post("bake", {{"between", "--step"}}).status, 400);
  for (const char* path : {"/view", "/weights", "/frames", "/plate"})
    EXPECT_EQ(Get(path).status, 404) << path;
  EXPECT_EQ(Get("/pose", {{"after", "x"}}).status, 400);
}

}  // namespace keypose::studio::armature_routes_test
