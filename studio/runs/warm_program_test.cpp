#include "studio/runs/warm_program.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "studio/runs/children.h"

namespace keypose::studio::warm_program_test {

namespace fs = std::filesystem;

class Warm : public ::testing::Test, public TestingFolder {
 protected:
  /// A script that says when it was started, and then what it was given.
  void WriteProgram(const char* name) {
    WriteFile(program_, fmt::format("#!/bin/sh\n: >> {}.$$\necho {} $1; tr '\\0' ' '; exit 3\n",
                                    (folder_ / "started").string(), name));
    fs::permissions(program_, fs::perms::owner_all);
  }
  int Started() const {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(folder_))
      count += entry.path().filename().string().starts_with("started");
    return count;
  }
  /// Whether so many have been started, soon.
  bool Start(int count) const {
    for (int i = 0; i < 100 && Started() < count; ++i) usleep(50'000);
    return Started() == count;
  }
  void SetUp() override { ::signal(SIGPIPE, SIG_IGN); }

  const fs::path program_ = folder_ / "program";
};

TEST_F(Warm, TheOneThatWaitsIsUsedAndTheNextOneWaits) {
  WriteProgram("one");
  WarmProgram warm(program_, folder_);
  warm.Warm();
  warm.Warm();
  EXPECT_TRUE(Start(1));
  const ChildResult first = warm.Run({"--mesh", "a b"}, 20);
  EXPECT_EQ(first.output, "one --await\n--mesh a b ");
  EXPECT_EQ(first.exit_code, 3);
  EXPECT_TRUE(Start(2));
  EXPECT_EQ(warm.Run({}, 20).output, "one --await\n");
}

TEST_F(Warm, OneThatWasReplacedIsNotUsed) {
  WriteProgram("old");
  WarmProgram warm(program_, folder_);
  warm.Warm();
  EXPECT_TRUE(Start(1));
  fs::remove(program_);
  WriteProgram("new");
  fs::last_write_time(program_, fs::last_write_time(program_) + std::chrono::seconds(1));
  EXPECT_EQ(warm.Run({"x"}, 20).output, "new --await\nx ");
}

TEST_F(Warm, AnAnswerStandsThoughTheNextOneCannotBeStarted) {
  WriteProgram("one");
  WarmProgram warm(program_, folder_);
  warm.Warm();
  ASSERT_TRUE(Start(1));
  // The two pipes of the next one would need four files; the one that waits leaves two.
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  const int first_free = dup(0);
  close(first_free);
  const rlimit none_left{static_cast<rlim_t>(first_free), before.rlim_max};
  setrlimit(RLIMIT_NOFILE, &none_left);
  const ChildResult result = warm.Run({"x"}, 20);
  EXPECT_THROW(warm.Warm(), Error);
  setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_EQ(result.output, "one --await\nx ");
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_EQ(warm.Run({"y"}, 20).output, "one --await\ny ");
}

}  // namespace keypose::studio::warm_program_test
