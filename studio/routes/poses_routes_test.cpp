// Photographs and poses as the page changes them: what becomes of the project's files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/image.h"
#include "studio/project/moves.h"
#include "studio/project/snapshot.h"
#include "studio/routes/routes.h"

namespace keypose::studio::poses_routes_test {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kFile[] =
    "# our dog\nposes:\n  rest: photos/rest   # a ring\n  wave: {photos: photos/wave, method: "
    "fit}\ntemplate: rest\ntimeline: [rest, wave, rest]\n";

class PosesRoutes : public ::testing::Test {
 protected:
  PosesRoutes() {
    fs::create_directories(Path("landmarks"));
    WriteFile(Path("pipeline.yaml"), kFile);
    for (const char* name : {"rest/a.jpg", "rest/b.jpg", "rest/c.jpg", "wave/a.jpg", "wave/b.jpg"})
      Picture(fs::path("photos") / name, shade_ += 10);
    WriteFile(Path("landmarks/wave.json"), "{\"pixels\": []}");
    routes_ = std::make_unique<Routes>(folder_);
  }
  ~PosesRoutes() override { routes_.reset(); }

  fs::path Path(const fs::path& below) const { return folder_ / below; }
  void Picture(const fs::path& below, int shade) {
    fs::create_directories(Path(below).parent_path());
    WriteImage(Path(below), Image8(32, 24, 3, static_cast<std::uint8_t>(shade)));
  }
  std::string Text() const { return ReadFile(Path("pipeline.yaml")); }

  Answer Post(const std::string& path, const json& body) {
    return routes_->Handle({"POST", "/api/" + path, {}, body.dump()});
  }
  void Do(const std::string& path, const json& body) {
    const Answer answer = Post(path, body);
    EXPECT_EQ(answer.status, 200) << answer.bytes;
  }
  std::string Refused(const std::string& path, const json& body) {
    const Answer answer = Post(path, body);
    EXPECT_EQ(answer.status, 400) << answer.bytes;
    return answer.bytes;
  }
  json Get(const std::string& path, const std::map<std::string, std::string>& query = {}) {
    const Answer answer = routes_->Handle({"GET", "/api/" + path, query, ""});
    EXPECT_EQ(answer.status, 200) << answer.bytes;
    return json::parse(answer.bytes);
  }
  std::vector<std::string> LeftOut(const std::string& pose) {
    std::vector<std::string> names;
    for (const json& one : Get("photos", {{"pose", pose}}))
      if (one.at("left_out").get<bool>()) names.push_back(one.at("name"));
    return names;
  }
  std::vector<std::string> Poses() {
    std::vector<std::string> names;
    const json project = Get("project");
    for (const json& pose : project.at("poses")) names.push_back(pose.at("name"));
    return names;
  }

  const TestingFolder own_;
  const fs::path folder_ = own_.path() / "dog";
  int shade_ = 0;
  std::unique_ptr<Routes> routes_;
};

TEST_F(PosesRoutes, APhotographIsLeftOutAndTakenBackInPipelineYaml) {
  Do("photos/leave-out", {{"pose", "rest"}, {"names", {"b.jpg", "c.jpg"}}, {"out", true}});
  EXPECT_THAT(Text(), HasSubstr("rest: {photos: photos/rest, options: {capture: {leave_out: "
                                "\"b.jpg; c.jpg\"}}}   # a ring\n"));
  EXPECT_THAT(LeftOut("rest"), ElementsAre("b.jpg", "c.jpg"));
  EXPECT_THAT(LeftOut("wave"), ElementsAre());
  EXPECT_TRUE(fs::exists(Path("photos/rest/b.jpg"))) << "it stays where it is";
  Do("photos/leave-out", {{"pose", "rest"}, {"names", {"b.jpg"}}, {"out", false}});
  EXPECT_THAT(LeftOut("rest"), ElementsAre("c.jpg"));
  Do("photos/leave-out", {{"pose", "rest"}, {"names", {"c.jpg"}}, {"out", false}});
  EXPECT_THAT(Text(), Not(HasSubstr("leave_out")));
  EXPECT_THAT(
      Refused("photos/leave-out", {{"pose", "rest"}, {"names", {"none.jpg"}}, {"out", true}}),
      HasSubstr("no photograph 'none.jpg'"));
}

TEST_F(PosesRoutes, OnlyTheStepsOfItsPoseRunAgain) {
  const auto recipe = [&](const std::string& pose) {
    Snapshot now(folder_);
    const auto& steps = now.graph().steps;
    for (std::size_t i = 0; i < steps.size(); ++i)
      if (steps[i].id == "capture/" + pose) return now.plan()[static_cast<int>(i)].fingerprint;
    return std::string();
  };
  const std::string rest = recipe("rest"), wave = recipe("wave");
  ASSERT_EQ(rest.size(), 64U);
  Do("photos/leave-out", {{"pose", "wave"}, {"names", {"a.jpg"}}, {"out", true}});
  EXPECT_EQ(recipe("rest"), rest);
  EXPECT_NE(recipe("wave"), wave);
  Do("photos/leave-out", {{"pose", "wave"}, {"names", {"a.jpg"}}, {"out", false}});
  EXPECT_EQ(recipe("wave"), wave) << "the cache has it";
  const json again = Get("photos/again", {{"pose", "wave"}});
  EXPECT_EQ(again.at("step"), "capture/wave");
  EXPECT_FALSE(again.at("made").get<bool>());
  EXPECT_THAT(again.at("follow").dump(), HasSubstr("fit/wave"));
  EXPECT_THAT(again.at("follow").dump(), Not(HasSubstr("dense/rest")));
}

TEST_F(PosesRoutes, APhotographOfASubfolderIsLeftOutByItsPath) {
  fs::create_directories(Path("photos/rest/lying"));
  for (const char* name : {"a.jpg", "b.jpg", "c.jpg"})
    fs::rename(Path("photos/rest") / name, Path("photos/rest/lying") / name);
  Do("photos/leave-out", {{"pose", "rest"}, {"names", {"lying_b.jpg"}}, {"out", true}});
  EXPECT_THAT(Text(), HasSubstr("leave_out: lying/b.jpg"));
  EXPECT_THAT(LeftOut("rest"), ElementsAre("lying_b.jpg"));
}

TEST_F(PosesRoutes, WhatIsDeletedComesBackWithItsMask) {
  const std::string bytes = ReadFile(Path("photos/rest/b.jpg"));
  const Answer mask =
      routes_->Handle({"PUT",
                       "/api/mask",
                       {{"pose", "rest"}, {"name", "b.jpg"}, {"revision", ""}, {"photograph", ""}},
                       [&] {
                         WriteImage(Path("m.png"), Image8(32, 24, 1, 255));
                         return ReadFile(Path("m.png"));
                       }()});
  ASSERT_EQ(mask.status, 200) << mask.bytes;
  WriteFile(Path("photos/rest/b.cr2"), "raw");
  Do("photos/leave-out", {{"pose", "rest"}, {"names", {"b.jpg"}}, {"out", true}});
  const std::string before = Text();
  Do("photos/delete", {{"pose", "rest"}, {"names", {"b.jpg"}}});
  EXPECT_FALSE(fs::exists(Path("photos/rest/b.jpg")));
  EXPECT_FALSE(fs::exists(Path("photos/rest/b.cr2"))) << "it would be taken in place of the other";
  EXPECT_EQ(ReadFile(Path("bin/0001/photos/rest/b.jpg")), bytes);
  EXPECT_TRUE(fs::exists(Path("bin/0001/masks/rest/b.jpg.png")));
  EXPECT_THAT(Text(), Not(HasSubstr("leave_out")));
  const json bin = Get("bin");
  ASSERT_EQ(bin.size(), 1U);
  EXPECT_EQ(bin[0].at("names"), json::array({"b.jpg"}));
  Do("bin/take-back", {{"id", bin[0].at("id")}});
  EXPECT_EQ(ReadFile(Path("photos/rest/b.jpg")), bytes);
  EXPECT_TRUE(fs::exists(Path("photos/rest/b.cr2")));
  EXPECT_TRUE(fs::exists(Path("masks/rest/b.jpg.png")));
  EXPECT_EQ(Text(), before);
  EXPECT_FALSE(fs::exists(Path("bin/0001")));
}

TEST_F(PosesRoutes, TheBinNeverOverwrites) {
  Do("photos/delete", {{"pose", "rest"}, {"names", {"b.jpg"}}});
  Picture("photos/rest/b.jpg", 200);
  const std::string newer = ReadFile(Path("photos/rest/b.jpg"));
  EXPECT_THAT(Refused("bin/take-back", {{"id", "0001"}}),
              HasSubstr("there is a photos/rest/b.jpg already"));
  EXPECT_EQ(ReadFile(Path("photos/rest/b.jpg")), newer);
  EXPECT_TRUE(fs::exists(Path("bin/0001/photos/rest/b.jpg")));
  EXPECT_EQ(Refused("bin/take-back", {{"id", "../photos"}}).empty(), false);
}

TEST_F(PosesRoutes, AnotherPhotographTakesThePlaceOfOne) {
  const std::string old = ReadFile(Path("photos/rest/b.jpg"));
  Picture("new.png", 90);
  Do("photos/leave-out", {{"pose", "rest"}, {"names", {"b.jpg"}}, {"out", true}});
  const Answer answer =
      routes_->Handle({"PUT",
                       "/api/photos",
                       {{"pose", "rest"}, {"name", "IMG_9.png"}, {"replaces", "b.jpg"}},
                       ReadFile(Path("new.png"))});
  ASSERT_EQ(answer.status, 200) << answer.bytes;
  EXPECT_EQ(ReadFile(Path("photos/rest/b.png")), ReadFile(Path("new.png")));
  EXPECT_FALSE(fs::exists(Path("photos/rest/b.jpg")));
  EXPECT_EQ(ReadFile(Path("bin/0001/photos/rest/b.jpg")), old);
  EXPECT_THAT(LeftOut("rest"), ElementsAre()) << "the new one is read";
}

TEST_F(PosesRoutes, ARenamedPoseTakesItsFilesAndKeysAlong) {
  Do("poses/rename", {{"pose", "wave"}, {"name", "Füße"}});
  EXPECT_EQ(Text(),
            "# our dog\nposes:\n  rest: photos/rest   # a ring\n  Füße: {photos: photos/Füße, "
            "method: fit}\ntemplate: rest\ntimeline: [rest, Füße, rest]\n");
  EXPECT_TRUE(fs::exists(Path("photos/Füße/a.jpg")));
  EXPECT_FALSE(fs::exists(Path("photos/wave")));
  EXPECT_TRUE(fs::exists(Path("landmarks/Füße.json")));
  Do("poses/rename", {{"pose", "rest"}, {"name", "sits"}});
  EXPECT_THAT(Text(), HasSubstr("  sits: photos/sits   # a ring\n"));
  EXPECT_THAT(Text(), HasSubstr("template: sits\ntimeline: [sits, Füße, sits]\n"));
}

TEST_F(PosesRoutes, ARenameIsAllOrNothing) {
  WriteFile(Path("landmarks/hi.json"), "of another");
  EXPECT_THAT(Refused("poses/rename", {{"pose", "wave"}, {"name", "hi"}}),
              HasSubstr("there is a landmarks/hi.json already"));
  EXPECT_EQ(Text(), kFile);
  EXPECT_TRUE(fs::exists(Path("photos/wave/a.jpg")));
  EXPECT_FALSE(fs::exists(Path("photos/hi")));
  for (const char* name : {"rest", "REST", "a b", "../x", ""})
    Refused("poses/rename", {{"pose", "wave"}, {"name", name}});
  EXPECT_EQ(Text(), kFile);
}

TEST_F(PosesRoutes, WhatEndedInTheMiddleOfAMoveIsPutBack) {
  {
    Moves moves(folder_);
    moves.Do("photos/wave", "photos/hi");
    fs::copy_file(Path(".keypose/studio/moves.json"), Path("notes"));
    moves.Keep();
  }
  fs::copy_file(Path("notes"), Path(".keypose/studio/moves.json"));
  UndoBrokenMoves(folder_);
  EXPECT_TRUE(fs::exists(Path("photos/wave/a.jpg")));
  EXPECT_FALSE(fs::exists(Path(".keypose/studio/moves.json")));
  fs::rename(Path("photos/wave"), Path("photos/hi"));
  fs::copy_file(Path("notes"), Path(".keypose/studio/moves.json"));
  WriteFile(Path("pipeline.yaml"), "poses: {rest: photos/rest}\n");
  UndoBrokenMoves(folder_);
  EXPECT_TRUE(fs::exists(Path("photos/hi/a.jpg"))) << "pipeline.yaml was written: it was whole";
}

TEST_F(PosesRoutes, ADeletedPoseComesBackWhole) {
  const std::string before = Text();
  Do("poses/delete", {{"pose", "wave"}});
  EXPECT_THAT(Poses(), ElementsAre("rest"));
  EXPECT_THAT(Text(), Not(HasSubstr("wave")));
  EXPECT_TRUE(fs::exists(Path("bin/0001/photos/wave/a.jpg")));
  EXPECT_TRUE(fs::exists(Path("bin/0001/landmarks/wave.json")));
  Do("bin/take-back", {{"id", "0001"}});
  EXPECT_THAT(Poses(), ElementsAre("rest", "wave"));
  EXPECT_EQ(Text(), before);
  EXPECT_TRUE(fs::exists(Path("photos/wave/a.jpg")));
  EXPECT_TRUE(fs::exists(Path("landmarks/wave.json")));
  EXPECT_THAT(Refused("poses/delete", {{"pose", "rest"}}), HasSubstr("choose another template"));
}

TEST_F(PosesRoutes, PosesAreAddedSortedAndOneIsTheTemplate) {
  Do("poses/add", {{"pose", "bow"}, {"few", false}});
  EXPECT_TRUE(fs::is_directory(Path("photos/bow")));
  Do("poses/order", {{"poses", {"bow", "rest", "wave"}}});
  EXPECT_THAT(Poses(), ElementsAre("bow", "rest", "wave"));
  EXPECT_EQ(Get("project").at("template"), "rest");
  EXPECT_THAT(Refused("poses/template", {{"pose", "wave"}}), HasSubstr("few photographs"));
  Do("poses/template", {{"pose", "bow"}});
  EXPECT_EQ(Get("project").at("template"), "bow");
  Do("poses/method", {{"pose", "wave"}, {"few", false}});
  EXPECT_THAT(Text(), HasSubstr("  wave: {photos: photos/wave}\n"));
  EXPECT_THAT(Text(), HasSubstr("# our dog\n"));
  EXPECT_EQ(Post("poses/method", {{"pose", "bow"}, {"few", true}}).status, 400);
}

}  // namespace keypose::studio::poses_routes_test
