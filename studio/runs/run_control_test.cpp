#include "studio/runs/run_control.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "studio/runs/children.h"

namespace keypose::studio {
namespace {

namespace fs = std::filesystem;

/// A project whose run an earlier studio has started: a program of the name that runs have.
class TakenUp : public testing::Test {
 protected:
  TakenUp() {
    fs::create_directories(state_);
    fs::copy_file("/bin/sleep", folder_ / "keypose");
    run_ = StartChild({(folder_ / "keypose").string(), "60"}, folder_, state_ / "run.jsonl",
                      state_ / "run.txt");
    WriteFile(state_ / "run.json", nlohmann::json{{"pid", run_}}.dump());
    // Its name is known when it has become the program.
    for (int i = 0; i < 100 && fs::read_symlink(Exe()).filename() != "keypose"; ++i) usleep(20'000);
  }
  ~TakenUp() override {
    if (run_ > 0) kill(run_, SIGKILL), waitpid(run_, nullptr, 0);
    fs::remove_all(folder_);
  }
  fs::path Exe() const { return "/proc/" + std::to_string(run_) + "/exe"; }
  /// Whether the run ends within a moment.
  bool Ends() {
    for (int i = 0; i < 25; ++i, usleep(20'000))
      if (waitpid(run_, nullptr, WNOHANG) == run_) {
        run_ = -1;
        return true;
      }
    return false;
  }

  const fs::path folder_ =
      fs::temp_directory_path() / ("run_control_test_" + std::to_string(getpid()));
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

}  // namespace
}  // namespace keypose::studio
