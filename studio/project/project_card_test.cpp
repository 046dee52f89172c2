#include "studio/project/project_card.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/io/pictures/image_io.h"
#include "core/testing/folder.h"
#include "studio/project/not_found.h"

namespace keypose::studio::project_card_test {

using nlohmann::json;

/// Of one step, whose program is the project's own: no stage of Keypose's is needed.
class ProjectCardTest : public TestingFolder, public ::testing::Test {
 protected:
  void MakeProject() {
    fs::create_directories(folder_ / "photos/rest");
    fs::create_directories(folder_ / "photos/wave");
    Put("tool", R"(#!/bin/sh
echo '{"schema": 1, "stage": "tool", "version": "1", "summary": "for this test", "inputs": [],'
echo '"outputs": [{"name": "made", "kind": "file", "file": "made.txt"}], "options": []}'
)");
    fs::permissions(folder_ / "tool", fs::perms::owner_all);
    std::string steps;
    for (const char* step :
         {"capture", "sfm", "masks", "dense", "mesh", "refine", "cleanup", "unwrap", "bake",
          "complete", "register", "interpolate", "export", "report"})
      steps += std::string("  ") + step + ": {enabled: false}\n";
    Put("pipeline.yaml", "poses: {rest: photos/rest, wave: photos/wave}\nsteps:\n" + steps +
                             "  tool: {program: tool, for: project, out: {made: made.txt}}\n");
  }
};

TEST_F(ProjectCardTest, TellsOfAProjectThatHasNotRun) {
  MakeProject();
  const json card = ProjectCardJson(folder_);
  EXPECT_EQ(card["problem"], "");
  EXPECT_EQ(card["state"], "new");
  EXPECT_EQ(card["done"], 0);
  EXPECT_EQ(card["steps"], 1);
  EXPECT_EQ(card["poses"], 2);
  EXPECT_EQ(card["kind"], "poses");
  EXPECT_FALSE(card["picture"]);
  EXPECT_THROW(ProjectPicture(folder_), NotFound) << "it has no photograph yet";
}

TEST_F(ProjectCardTest, SaysWhatIsWrong) {
  EXPECT_EQ(ProjectCardJson(folder_)["state"], "empty");
  Put("pipeline.yaml", "poses: [1, {\n");
  const json card = ProjectCardJson(folder_);
  EXPECT_EQ(card["state"], "broken");
  EXPECT_NE(card["problem"].get<std::string>().find("pipeline.yaml"), std::string::npos);
  EXPECT_THROW(ProjectPicture(folder_), NotFound);
}

TEST_F(ProjectCardTest, ThePictureIsTheTemplatesFirstPhotographMadeSmall) {
  MakeProject();
  Image8 photograph{640, 320, 3, {}};
  photograph.data.assign(640 * 320 * 3, 90);
  WriteImage(folder_ / "photos/rest/b.png", photograph);
  photograph.data.assign(640 * 320 * 3, 200);
  WriteImage(folder_ / "photos/rest/a.png", photograph);
  EXPECT_TRUE(ProjectCardJson(folder_)["picture"]);
  const Image8 picture = ReadImage(ProjectPicture(folder_), 3);
  EXPECT_EQ(picture.width, 480);
  EXPECT_EQ(picture.height, 240);
  EXPECT_NEAR(picture.data[0], 200, 2);
}

}  // namespace keypose::studio::project_card_test
