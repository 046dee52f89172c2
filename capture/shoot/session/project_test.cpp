#include "capture/shoot/session/project.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot::project_test {

namespace fs = std::filesystem;

constexpr int kRing = 24;

class Project : public ::testing::Test {
 protected:
  Project() { fs::create_directories(folder_); }
  std::string Text() const { return ReadFile(folder_ / "pipeline.yaml"); }
  void Write(const std::string& text) const { WriteFile(folder_ / "pipeline.yaml", text); }
  const TestingFolder beside_;
  const fs::path folder_ = beside_.path() / "fox";
};

TEST_F(Project, IsMadeWithItsFirstPose) {
  EXPECT_EQ(AddPose(folder_, "standing", kRing).folder, folder_ / "photos/standing");
  EXPECT_NE(Text().find("name: \"fox\"\nposes:\n  standing: photos/standing\ntemplate: standing\n"),
            std::string::npos);
}

TEST_F(Project, GetsFurtherPosesAtTheEndOfItsTimeline) {
  for (const char* pose : {"rest", "bent", "wave"}) AddPose(folder_, pose, kRing);
  EXPECT_NE(Text().find("  rest: photos/rest\n  bent: photos/bent\n  wave: photos/wave\n"),
            std::string::npos);
  EXPECT_NE(Text().find("timeline: [rest, bent, wave]"), std::string::npos);
}

TEST_F(Project, KeepsCommentsAndATimelineOfItsOwn) {
  const std::string text =
      "# our hero\nposes:\n  rest: photos/rest   # first\n\ntimeline: [rest, rest]  # a hold\n";
  Write(text);
  AddPose(folder_, "bent", kRing);
  EXPECT_EQ(Text(),
            "# our hero\nposes:\n  rest: photos/rest   # first\n  bent: photos/bent\n\n"
            "timeline: [rest, rest]  # a hold\n");
}

TEST_F(Project, BendsItsFirstPoseIntoFewPhotographsOfAnother) {
  EXPECT_EQ(AddPose(folder_, "rest", 6).bent_from, "") << "the first is scanned";
  EXPECT_EQ(AddPose(folder_, "wave", 15).bent_from, "rest");
  EXPECT_EQ(AddPose(folder_, "bow", 16).bent_from, "");
  EXPECT_NE(Text().find("  rest: photos/rest\n  wave: {photos: photos/wave, method: fit}\n"
                        "  bow: photos/bow\n"),
            std::string::npos);
  EXPECT_EQ(AddPose(folder_, "wave", 24).bent_from, "rest") << "decided once";
}

TEST_F(Project, DecidesHowAPoseIsFoundWhileItHasNoPhotographs) {
  Write("poses:\n  rest: photos/rest\n  wave: photos/wave  # soon\n  bow: {method: scan}\n");
  AddPose(folder_, "rest", 6);
  AddPose(folder_, "wave", 6);
  AddPose(folder_, "bow", 6);
  EXPECT_EQ(Text(),
            "poses:\n  rest: photos/rest\n  wave: {photos: photos/wave, method: fit}  # soon\n"
            "  bow: {method: scan}\n");
  Write("poses:\n  rest: photos/rest\n  wave: photos/wave\n");
  fs::create_directories(folder_ / "photos/wave");
  WriteFile(folder_ / "photos/wave/a.jpg", "");
  EXPECT_EQ(AddPose(folder_, "wave", 6).bent_from, "") << "there are photographs already";
}

TEST_F(Project, IsLeftAloneIfItHasThePoseWhereverItsPhotographsAre) {
  const std::string text = "poses:\n  rest: {photos: pictures/rest}\n  bent: ../bent\n";
  Write(text);
  EXPECT_EQ(AddPose(folder_, "rest", kRing).folder, folder_ / "pictures/rest");
  EXPECT_EQ(AddPose(folder_, "bent", kRing).folder, folder_.parent_path() / "bent");
  EXPECT_EQ(Text(), text);
}

TEST_F(Project, WithAFileThatCannotBeReadIsRefused) {
  Write("poses: [\n");
  EXPECT_THROW(AddPose(folder_, "rest", kRing), UsageError);
  EXPECT_EQ(Text(), "poses: [\n");
}

TEST_F(Project, RefusesNamesThatAreNoPoses) {
  for (const char* name : {"", "a b", "../x", "-x", "a/b", "a:b", "\xff"})
    EXPECT_THROW(AddPose(folder_, name, kRing), UsageError) << name;
  EXPECT_NO_THROW(AddPose(folder_, "Füße-2_b", kRing));
}

TEST_F(Project, IsShotIntoByOneSessionAtATime) {
  {
    const ShootLock lock(folder_ / ".keypose/shoot");
    EXPECT_THROW(ShootLock(folder_ / ".keypose/shoot"), LockedError);
  }
  EXPECT_NO_THROW(ShootLock(folder_ / ".keypose/shoot"));
}

}  // namespace keypose::capture::shoot::project_test
