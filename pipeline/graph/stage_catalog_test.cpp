// What is remembered of stage programs, in a project and for all projects of a user.
#include "pipeline/graph/stage_catalog.h"

#include <gtest/gtest.h>

#include "pipeline/testing/fake_house.h"

namespace keypose::pipeline::stage_catalog_test {

constexpr char kShared[] = "/home/ada/.cache/keypose/stages.json";
const std::vector<std::filesystem::path> kPrograms = {"/bin/keypose-shoot", "/bin/keypose-solve"};

class StageCatalogTest : public ::testing::Test {
 protected:
  /// How many programs a command in this project has to run.
  int AskedIn(const std::string& project) {
    StageCatalog catalog(house_.disk, house_.processes, project + "/.keypose/stages.json", kShared);
    catalog.Load(kPrograms);
    EXPECT_EQ(catalog.Get(kPrograms[1]).stage, "solve");
    return catalog.asked();
  }
  FakeHouse house_;
};

TEST_F(StageCatalogTest, ASecondProjectAndASecondCommandAskNothing) {
  EXPECT_EQ(AskedIn("/one"), 2);
  EXPECT_EQ(AskedIn("/one"), 0);
  EXPECT_EQ(AskedIn("/two"), 0);
  house_.disk.Remove(kShared);
  EXPECT_EQ(AskedIn("/two"), 0) << "the project keeps what it took from the shared file";
}

TEST_F(StageCatalogTest, AProgramThatWasReplacedIsAskedAgain) {
  AskedIn("/one");
  house_.disk.Write("/bin/keypose-solve", "a newer one");
  EXPECT_EQ(AskedIn("/two"), 1);
  EXPECT_EQ(AskedIn("/one"), 0) << "by what the other project learnt";
}

TEST_F(StageCatalogTest, ADamagedSharedFileCountsAsNone) {
  for (const char* text :
       {"{\"/bin/keypose-solve\": 3}", "[]", "{", "{\"/bin/keypose-solve\": {}}"}) {
    house_.disk.Remove("/one");
    house_.disk.Write(kShared, text);
    EXPECT_EQ(AskedIn("/one"), 2) << text;
  }
}

TEST_F(StageCatalogTest, WhatCannotBeSavedIsAskedEachTime) {
  house_.disk.SetFull(true);
  EXPECT_EQ(AskedIn("/one"), 2);
  EXPECT_EQ(AskedIn("/one"), 2);
}

TEST_F(StageCatalogTest, ProgramsThatAreGoneLeaveTheSharedFile) {
  house_.disk.Write(kShared, "{\"/old/keypose-solve\": {\"describe\": \"\"}}");
  AskedIn("/one");
  EXPECT_EQ(house_.disk.Read(kShared).find("/old/"), std::string::npos);
}

}  // namespace keypose::pipeline::stage_catalog_test
