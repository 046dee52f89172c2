#include "studio/runs/children.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>

#include "core/io/text/files.h"
#include "core/testing/folder.h"

namespace keypose::studio::children_test {

namespace fs = std::filesystem;

class Talking : public ::testing::Test, public TestingFolder {
 protected:
  Talking() { ::signal(SIGPIPE, SIG_IGN); }

  TalkingChild Shell(const std::string& script) const {
    return TalkingChild({"/bin/sh", "-c", script}, "/", error_);
  }
  /// Its next line; "" when it has ended before.
  static std::string NextLine(TalkingChild& child) {
    std::string line;
    TalkingChild::Heard heard = TalkingChild::Heard::kNothing;
    while (heard == TalkingChild::Heard::kNothing) heard = child.Hear(&line);
    return heard == TalkingChild::Heard::kLine ? line : "";
  }

  const fs::path error_ = folder_ / "error";
};

TEST_F(Talking, LinesGoInAndComeOutWhole) {
  TalkingChild child = Shell("while read line; do echo \"<$line>\"; done; printf 'half'; exit 7");
  EXPECT_TRUE(child.Say("one"));
  EXPECT_TRUE(child.Say("two"));
  EXPECT_EQ(NextLine(child), "<one>");
  EXPECT_EQ(NextLine(child), "<two>");
}

TEST_F(Talking, EndIsToldAfterTheLastLine) {
  TalkingChild child = Shell("echo last; echo 'keypose: error: the cable is out' >&2; exit 5");
  EXPECT_EQ(NextLine(child), "last");
  EXPECT_EQ(NextLine(child), "");
  EXPECT_EQ(child.Wait(), 5);
  EXPECT_EQ(WhatItSaid(error_, 5), "the cable is out");
  EXPECT_FALSE(child.Say("is anybody there?"));
}

TEST_F(Talking, SilentOnesHoldNobodyUp) {
  TalkingChild child = Shell("sleep 60");
  std::string line;
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(child.Hear(&line), TalkingChild::Heard::kNothing);
  // One that does not read takes what fits into a pipe, and no more.
  bool taken = true;
  for (int i = 0; i < 100 && taken; ++i) taken = child.Say(std::string(10000, 'x'));
  EXPECT_FALSE(taken);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
  child.Interrupt();
  EXPECT_EQ(child.Wait(), 128 + SIGINT);
}

TEST_F(Talking, OnesThatAreLeftReadTheEndOfTheirInput) {
  const fs::path mark = error_.string() + ".mark";
  {
    TalkingChild child = Shell("echo ready; cat > /dev/null; : > " + mark.string());
    EXPECT_EQ(NextLine(child), "ready");
  }
  for (int i = 0; i < 100 && !fs::exists(mark); ++i) usleep(50'000);
  EXPECT_TRUE(fs::remove(mark));
}

TEST(RunChild, LateOnesAreStopped) {
  const ChildResult result = RunChild({"/bin/sh", "-c", "echo begun; sleep 60"}, "/", 0.5);
  EXPECT_EQ(result.exit_code, 124);
  EXPECT_EQ(result.output, "begun\n");
}

TEST(LetGo, OnesThatAreThePersonsGoOnAndHoldNobodyUp) {
  const TestingFolder folder;
  const fs::path mark = folder.path() / "mark";
  const auto begin = std::chrono::steady_clock::now();
  // As xdg-open may do: what it starts keeps its output, and stays when it has ended.
  LetGo({"/bin/sh", "-c", "(sleep 1; pwd > \"$0.part\"; mv \"$0.part\" \"$0\") & exit 0",
         mark.string()},
        "/usr");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(900));
  for (int i = 0; i < 200 && !fs::exists(mark); ++i) usleep(50'000);
  EXPECT_EQ(ReadFile(mark), "/usr\n");
  EXPECT_NO_THROW(LetGo({"/nonexistent/program"}, "/"));
}

TEST(WarningsIn, AreThoseOfAStageThatSucceeded) {
  EXPECT_EQ(WarningsIn("armature bake: 12 frames\n"), "");
  EXPECT_EQ(WarningsIn("armature bake: reading\narmature bake: warning: a joint is left out\n"
                       "armature bake: warning: a chain misses its anchor\n"),
            "a joint is left out\na chain misses its anchor");
}

TEST(WhatItSaid, ExitCodeSpeaksForThoseWhoSayNothing) {
  EXPECT_EQ(WhatItSaid("/nonexistent/file", 5), "the program ended with exit code 5");
  EXPECT_EQ(WhatItSaid("/nonexistent/file", 0), "");
}

}  // namespace keypose::studio::children_test
