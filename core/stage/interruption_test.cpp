#include "core/stage/interruption.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>

#include "core/stage/testing/copy_stage.h"
#include "core/testing/paths.h"

namespace keypose::interruption_test {

namespace fs = std::filesystem;

/// Starts a program that is stuck, sends signals, and returns its exit code.
int EndStuck(const fs::path& folder, const std::vector<int>& signals) {
  const std::string text = folder / "in.txt", copy = folder / "out.txt";
  const pid_t child = fork();
  if (child == 0) {
    execl((BinFolder() + "/testing/core_stuck_stage").c_str(), "stuck", "--text", text.c_str(),
          "--copy", copy.c_str(), nullptr);
    _exit(127);
  }
  while (!fs::exists(folder / "stuck") && waitpid(child, nullptr, WNOHANG) == 0) usleep(1000);
  for (const int signal : signals) kill(child, signal), usleep(20000);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_F(StageTest, SignalEndsItInACallThatCannotBeAskedAndLeavesNothing) {
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(EndStuck(folder_, {SIGTERM}), 130);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(100)) << "of 300";
  fs::remove(folder_ / "stuck");
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
    EXPECT_EQ(entry.path().filename(), "in.txt") << "litter";
}

TEST_F(StageTest, SecondSignalEndsItAtOnce) {
  EXPECT_EQ(EndStuck(folder_, {SIGINT, SIGINT}), 130);
  EXPECT_FALSE(fs::exists(folder_ / "out.txt"));
}

}  // namespace keypose::interruption_test
