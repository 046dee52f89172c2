#include "capture/shoot/session/project.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot::project_test {

namespace fs = std::filesystem;

class Project : public ::testing::Test {
 protected:
  Project() { fs::create_directories(folder_); }
  std::string Text() const { return ReadFile(folder_ / "pipeline.yaml"); }
  void Write(const std::string& text) const { WriteFile(folder_ / "pipeline.yaml", text); }
  const TestingFolder beside_;
  const fs::path folder_ = beside_.path() / "fox";
};

TEST_F(Project, IsMadeWithItsFirstPose) {
  EXPECT_EQ(AddPose(folder_, "standing"), folder_ / "photos/standing");
  EXPECT_NE(Text().find("name: \"fox\"\nposes:\n  standing: photos/standing\ntemplate: standing\n"),
            std::string::npos);
}

TEST_F(Project, GetsFurtherPosesAtTheEndOfItsTimeline) {
  for (const char* pose : {"rest", "bent", "wave"}) AddPose(folder_, pose);
  EXPECT_NE(Text().find("  rest: photos/rest\n  bent: photos/bent\n  wave: photos/wave\n"),
            std::string::npos);
  EXPECT_NE(Text().find("timeline: [rest, bent, wave]"), std::string::npos);
}

TEST_F(Project, KeepsCommentsAndATimelineOfItsOwn) {
  const std::string text =
      "# our hero\nposes:\n  rest: photos/rest   # first\n\ntimeline: [rest, rest]  # a hold\n";
  Write(text);
  AddPose(folder_, "bent");
  EXPECT_EQ(Text(),
            "# our hero\nposes:\n  rest: photos/rest   # first\n  bent: photos/bent\n\n"
            "timeline: [rest, rest]  # a hold\n");
}

TEST_F(Project, IsLeftAloneIfItHasThePoseWhereverItsPhotographsAre) {
  const std::string text = "poses:\n  rest: {photos: pictures/rest}\n  bent: ../bent\n";
  Write(text);
  EXPECT_EQ(AddPose(folder_, "rest"), folder_ / "pictures/rest");
  EXPECT_EQ(AddPose(folder_, "bent"), folder_.parent_path() / "bent");
  EXPECT_EQ(Text(), text);
}

TEST_F(Project, WithAFileThatCannotBeReadIsRefused) {
  Write("poses: [\n");
  EXPECT_THROW(AddPose(folder_, "rest"), UsageError);
  EXPECT_EQ(Text(), "poses: [\n");
}

TEST_F(Project, RefusesNamesThatAreNoPoses) {
  for (const char* name : {"", "a b", "../x", "-x", "a/b", "a:b", "\xff"})
    EXPECT_THROW(AddPose(folder_, name), UsageError) << name;
  EXPECT_NO_THROW(AddPose(folder_, "Füße-2_b"));
}

TEST_F(Project, IsShotIntoByOneSessionAtATime) {
  {
    const ShootLock lock(folder_ / ".keypose/shoot");
    EXPECT_THROW(ShootLock(folder_ / ".keypose/shoot"), LockedError);
  }
  EXPECT_NO_THROW(ShootLock(folder_ / ".keypose/shoot"));
}

}  // namespace keypose::capture::shoot::project_test
