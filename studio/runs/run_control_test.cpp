#include "studio/runs/run_control.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "studio/runs/children.h"

namespace keypose::studio::run_control_test {

namespace fs = std::filesystem;

/// A project whose run an earlier studio has started: a program of the name that runs have.
class TakenUp : public ::testing::Test, public TestingFolder {
 protected:
  TakenUp() {
    fs::create_directories(state_);
    fs::copy_file("/bin/sleep", folder_ / "keypose");
    run_ = StartChild({(folder_ / "keypose").string(), "60"}, folder_, state_ / "run.jsonl",
                      state_ / "run.txt");
    Record(MarkOfProcess(run_));
  }
  ~TakenUp() override {
    if (run_ > 0) kill(run_, SIGKILL), waitpid(run_, nullptr, 0);
  }
  /// As the earlier studio has left it.
  void Record(const std::string& process) {
    WriteFile(state_ / "run.json", nlohmann::json{{"pid", run_}, {"process", process}}.dump());
  }
  /// Whether the run ends within a moment.
  bool Ends() {
    for (int i = 0; i < 25; ++i, usleep(20'000))
      if (waitpid(run_, nullptr, WNOHANG) == run_) {
        run_ = -1;
        return true;
      }
    return false;
  }

  const fs::path state_ = folder_ / ".keypose/studio";
  const RunControl::Listener nobody_{[](const std::string&) {}, [](int, const std::string&) {}};
  pid_t run_ = -1;
};

TEST_F(TakenUp, ARunOfAnEarlierStudioGoesOnWithoutThisOne) {
  {
    RunControl control(folder_, nobody_);
    control.TakeUp();
    EXPECT_TRUE(control.running());
  }
  EXPECT_FALSE(Ends());
}

TEST_F(TakenUp, ARunOfAnEarlierStudioIsStoppedWhenAsked) {
  RunControl control(folder_, nobody_);
  control.TakeUp();
  control.Stop();
  EXPECT_TRUE(Ends());
}

TEST_F(TakenUp, AnotherProcessOfThatNumberIsLeftAlone) {
  std::string earlier = MarkOfProcess(run_);
  ASSERT_FALSE(earlier.empty());
  earlier.back() = earlier.back() == '1' ? '2' : '1';
  for (const std::string& process : {earlier, std::string()}) {
    Record(process);
    RunControl control(folder_, nobody_);
    control.TakeUp();
    EXPECT_FALSE(control.running());
    control.Stop();
    EXPECT_FALSE(Ends());
  }
}

TEST_F(TakenUp, ARunThatHasEndedIsNotTakenUp) {
  kill(run_, SIGKILL);
  ASSERT_TRUE(Ends());
  RunControl control(folder_, nobody_);
  control.TakeUp();
  EXPECT_FALSE(control.running());
}

TEST(MarkOfProcess, IsOfOneProcessThatIsAtWork) {
  const std::string own = MarkOfProcess(getpid());
  EXPECT_EQ(own, MarkOfProcess(getpid()));
  EXPECT_NE(own, MarkOfProcess(1));
  EXPECT_EQ(MarkOfProcess(0), "");
  const pid_t ended = fork();
  if (ended == 0) _exit(0);
  siginfo_t info;
  waitid(P_PID, static_cast<id_t>(ended), &info, WEXITED | WNOWAIT);
  EXPECT_EQ(MarkOfProcess(ended), "") << "nobody has collected it yet";
  waitpid(ended, nullptr, 0);
}

}  // namespace keypose::studio::run_control_test
