#include "studio/server/door.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/testing/folder.h"

namespace keypose::studio::door_test {

using nlohmann::json;

class DoorTest : public TestingFolder, public ::testing::Test {
 protected:
  json Ask(const std::string& what, int status = 200) {
    const auto mark = what.find('?');
    Question question{"GET", "/api/door" + what.substr(0, mark), {}, ""};
    if (mark != std::string::npos) question.query["folder"] = what.substr(mark + 1);
    return Checked(door_.Handle(question), status);
  }
  json Post(const std::string& what, const json& body, int status = 200) {
    return Checked(door_.Handle({"POST", "/api/door" + what, {}, body.dump()}), status);
  }
  static json Checked(const Answer& answer, int status) {
    EXPECT_EQ(answer.status, status) << answer.bytes;
    return json::parse(answer.bytes);
  }
  std::string Project(const std::string& name) {
    fs::create_directories(folder_ / name / "photos/rest");
    Put(name + "/pipeline.yaml", "poses: {rest: photos/rest}\n");
    return (folder_ / name).string();
  }

  bool ended_ = false;
  Door door_{{folder_ / "home", folder_ / "state", folder_, [] { return "http://here/"; },
              [this] { ended_ = true; }}};
};

TEST_F(DoorTest, AProjectThatIsOpenedIsRememberedAndFirst) {
  const std::string fox = Project("fox"), hare = Project("hare");
  EXPECT_EQ(Ask("")["open"], "");
  EXPECT_EQ(door_.Now(), nullptr);
  EXPECT_EQ(door_.Mark(), "");
  for (const std::string& one : {fox, hare}) {
    EXPECT_EQ(Post("/open", {{"folder", one}})["open"], one);
    door_.RememberIt();
  }
  const json known = Ask("")["projects"];
  ASSERT_EQ(known.size(), 2U);
  EXPECT_EQ(known[0]["name"], "hare");
  EXPECT_EQ(known[1]["name"], "fox");
  EXPECT_TRUE(known[1]["there"]);
}

TEST_F(DoorTest, OneThatIsGoneIsSaidAndCanBeTakenOffTheList) {
  const std::string fox = Project("fox");
  Post("/open", {{"folder", fox}});
  door_.RememberIt();
  fs::rename(fox, folder_ / "moved");
  EXPECT_FALSE(Ask("")["projects"][0]["there"]);
  Ask("/card?" + fox, 404);
  EXPECT_TRUE(Post("/forget", {{"folder", fox}})["projects"].empty());
  EXPECT_TRUE(fs::exists(folder_ / "moved/pipeline.yaml"));
}

TEST_F(DoorTest, AnotherProjectHasAnotherMarkAndTheSameKeepsItsRoutes) {
  const std::string fox = Project("fox"), hare = Project("hare");
  door_.Open(fox);
  const std::string mark = door_.Mark();
  const auto routes = door_.Now();
  door_.Open(fox);
  EXPECT_EQ(door_.Now(), routes);
  door_.Open(hare);
  EXPECT_NE(door_.Mark(), mark);
  EXPECT_NE(door_.Now(), routes);
}

TEST_F(DoorTest, AFolderThatIsNoProjectIsRefusedWithWhatIsThere) {
  Project("all/fox");
  Put("all/a.jpg", "a");
  const json said = Post("/open", {{"folder", (folder_ / "all/").string()}}, 400);
  EXPECT_NE(said["error"].get<std::string>().find("its folder 'fox' is one"), std::string::npos);
  for (const std::string& wrong : {std::string("fox"), (folder_ / "none").string(), std::string(),
                                   (folder_ / "all/a.jpg").string()})
    Post("/open", {{"folder", wrong}}, 400);
  EXPECT_EQ(Post("/open", {{"folder", (folder_ / "all/fox/pipeline.yaml").string()}})["open"],
            (folder_ / "all/fox").string());
}

TEST_F(DoorTest, ANewProjectIsAFolderAtHome) {
  EXPECT_EQ(Post("/new", {{"name", "clay fox"}})["open"], (folder_ / "home/clay fox").string());
  for (const char* name : {"../fox", "", ".fox"}) Post("/new", {{"name", name}}, 400);
}

TEST_F(DoorTest, OnlyKnownFoldersAreLookedInto) {
  const std::string fox = Project("fox"), hare = Project("hare");
  door_.Open(fox);
  door_.RememberIt();
  EXPECT_EQ(Ask("/card?" + fox)["kind"], "poses");
  for (const std::string& other : {hare, fox + "/../hare", fox + "/", std::string("/etc")}) {
    Ask("/card?" + other, 404);
    Ask("/picture?" + other, 404);
  }
}

TEST_F(DoorTest, TheBoardIsPrintedByItsProgram) {
  Put("keypose-capture", "#!/bin/sh\nprintf '%s' \"%PDF $1\" > \"$2\"\n");
  fs::permissions(folder_ / "keypose-capture", fs::perms::owner_all);
  const Answer board = door_.Handle({"GET", "/api/door/board", {}, ""});
  EXPECT_EQ(board.status, 200);
  EXPECT_EQ(board.type, "application/pdf");
  EXPECT_EQ(board.bytes, "%PDF --print-board");
  EXPECT_EQ(board.download, "keypose_board.pdf");
  Put("keypose-capture", "#!/bin/sh\necho 'keypose capture: error: no paper' >&2; exit 5\n");
  EXPECT_EQ(Checked(door_.Handle({"GET", "/api/door/board", {}, ""}), 500)["error"], "no paper");
}

TEST_F(DoorTest, WhatIsWrongIsAnsweredInWords) {
  Post("/open", {{"folder", 3}}, 400);
  Post("/open", json::object(), 400);
  Post("/none", json::object(), 404);
  Ask("/none", 404);
  Post("/example", {{"kind", "six"}, {"base", "examples"}}, 400);
  Post("/example", {{"kind", "none"}, {"base", folder_.string()}}, 400);
  EXPECT_EQ(Post("/address", json::object())["address"], "http://here/");
  EXPECT_FALSE(ended_);
  Post("/end", json::object());
  EXPECT_TRUE(ended_);
}

}  // namespace keypose::studio::door_test
