#include "studio/project/known_projects.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::studio::known_projects_test {

namespace fs = std::filesystem;

class KnownProjectsTest : public TestingFolder, public ::testing::Test {
 protected:
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const KnownProject& one : KnownProjects(State()))
      names.push_back(one.folder.filename().string());
    return names;
  }
  fs::path State() const { return folder_ / "state/keypose"; }
};

using Names_t = std::vector<std::string>;

TEST_F(KnownProjectsTest, TheLatestIsFirstAndEachIsThereOnce) {
  EXPECT_TRUE(KnownProjects(State()).empty());
  Remember(State(), folder_ / "fox", 10);
  Remember(State(), folder_ / "hare", 20);
  Remember(State(), folder_ / "fox", 30);
  EXPECT_EQ(Names(), (Names_t{"fox", "hare"}));
  EXPECT_EQ(KnownProjects(State())[0].opened, 30);
  ForgetProject(State(), folder_ / "fox");
  EXPECT_EQ(Names(), (Names_t{"hare"}));
  for (int i = 0; i < 60; ++i) Remember(State(), folder_ / std::to_string(i), i);
  EXPECT_EQ(Names().size(), 50U);
  EXPECT_EQ(Names().front(), "59");
}

TEST_F(KnownProjectsTest, OneWhoseFolderHasNoProjectIsShownAsGone) {
  fs::create_directories(folder_ / "fox");
  std::ofstream(folder_ / "fox/pipeline.yaml") << "poses: {}\n";
  Remember(State(), folder_ / "fox", 1);
  EXPECT_TRUE(KnownProjects(State())[0].there);
  fs::remove(folder_ / "fox/pipeline.yaml");
  EXPECT_FALSE(KnownProjects(State())[0].there);
}

TEST_F(KnownProjectsTest, ADamagedListAndAPlaceThatCannotBeWrittenAreNoErrors) {
  fs::create_directories(State());
  std::ofstream(State() / "projects.json") << "{\"projects\": [{\"folder\": 7";
  EXPECT_TRUE(KnownProjects(State()).empty());
  Remember("/proc/none", folder_, 1);
  Remember("", folder_, 1);
}

TEST_F(KnownProjectsTest, ANewProjectGetsAFolderOfItsOwn) {
  EXPECT_EQ(NewProjectFolder(folder_ / "Keypose", "clay fox"), folder_ / "Keypose/clay fox");
  EXPECT_TRUE(fs::is_directory(folder_ / "Keypose/clay fox"));
  EXPECT_NO_THROW(NewProjectFolder(folder_ / "Keypose", "clay fox")) << "it is empty still";
  std::ofstream(folder_ / "Keypose/clay fox/a.txt") << "a";
  EXPECT_THROW(NewProjectFolder(folder_ / "Keypose", "clay fox"), UsageError);
  for (const char* name : {"", ".hidden", "..", "a/b", "a\nb"})
    EXPECT_THROW(NewProjectFolder(folder_, name), UsageError) << name;
  for (const char one : std::string(":*?\"<>|\n"))
    EXPECT_THROW(NewProjectFolder(folder_, std::string("a") + one), UsageError) << one;
  EXPECT_THROW(NewProjectFolder(folder_, std::string(300, 'x')), UsageError);
}

}  // namespace keypose::studio::known_projects_test
