// A separate installation of the program `keypose`, with a project of two poses. Its stages are
// small text programs.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"

namespace keypose::pipeline {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

inline constexpr char kTestPipeline[] =
    R"(sources: {photos: {of: pose, default: "photos/{pose}", always: true}}
steps:
  gather: {stage: gather, for: pose, inputs: {photos: $photos}}
  join: {stage: join, for: pose, inputs: {images: gather.images}, out: {text: "{pose}/text.txt"}}
  merge: {stage: merge, for: project, inputs: {texts: join.text@all}, out: {all: all}, show: {all: all texts, all/9.txt: the tenth}}
)";

inline double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}
inline void SleepSeconds(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// All files below a folder with their content. Ignores times and the run records.
inline std::map<std::string, std::string> Snapshot(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file())
      files[entry.path().lexically_relative(folder).string()] = ReadFile(entry.path());
  }
  return files;
}

/// The output of a run that has nothing to do.
inline std::string AllUpToDate(const fs::path& project) {
  return "5 steps up to date\n\nresults\n  all texts  " + (project / "out/all").string() + "\n";
}

struct Ended {
  int code = -1;
  std::string text;  ///< standard output and error
};

/// The first bytes of a TIFF, for photographs of test stages, which read text.
inline const std::string kPictureStart("II*\0", 4);

class RunTest : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override {
    Install(root_);
    MakeProject(root_ / "hero");
  }
  void TearDown() override {
    if (mounted_) umount2((root_ / "small").c_str(), MNT_DETACH);
  }

  /// Installs keypose and its test stages below `root`.
  static void Install(const fs::path& root) {
    fs::create_directories(root / "bin");
    fs::create_directories(root / "share/keypose");
    fs::copy_file(BinFolder() + "/keypose", root / "bin/keypose");
    for (const std::string stage : {"gather", "join", "merge"})
      fs::copy_file(BinFolder() + "/testing/pipeline_text_stage", root / ("bin/keypose-" + stage));
    WriteFile(root / "share/keypose/pipeline.yaml", kTestPipeline);
  }
  static void MakeProject(const fs::path& project) {
    for (const std::string pose : {"rest", "bent"}) {
      fs::create_directories(project / "photos" / pose);
      for (int i = 0; i < 4; ++i)
        WriteFile(project / "photos" / pose / ("IMG_" + std::to_string(i) + ".jpg"),
                  pose + " picture " + std::to_string(i) + "\n");
    }
    WriteFile(project / "pipeline.yaml", "poses: {rest: photos/rest, bent: photos/bent}\n");
  }

  /// Makes the project's photographs such that `init` takes them: their first bytes are a TIFF's.
  static void MakePhotographs(const fs::path& project) {
    for (const auto& entry : fs::recursive_directory_iterator(project / "photos"))
      if (entry.is_regular_file()) WriteFile(entry.path(), kPictureStart + ReadFile(entry.path()));
  }

  pid_t Start(const std::vector<std::string>& arguments,
              const std::map<std::string, std::string>& environment = {}) const {
    const pid_t pid = fork();
    if (pid != 0) return pid;
    const int out = open((root_ / ("output" + std::to_string(getpid()))).c_str(),
                         O_WRONLY | O_CREAT | O_TRUNC, 0666);
    dup2(out, 1);
    dup2(out, 2);
    for (const auto& [name, value] : environment) setenv(name.c_str(), value.c_str(), 1);
    std::vector<std::string> all = {(root_ / "bin/keypose").string()};
    all.insert(all.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& text : all) argv.push_back(text.data());
    argv.push_back(nullptr);
    execv(argv[0], argv.data());
    _exit(126);
  }
  Ended Finish(pid_t pid) const {
    int status = 0;
    waitpid(pid, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
            ReadFile(root_ / ("output" + std::to_string(pid)))};
  }
  Ended Keypose(const std::vector<std::string>& arguments,
                const std::map<std::string, std::string>& environment = {}) const {
    return Finish(Start(arguments, environment));
  }
  Ended Run(const std::vector<std::string>& more = {},
            const std::map<std::string, std::string>& environment = {}) const {
    std::vector<std::string> arguments = {"run", "-C", (root_ / "hero").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Keypose(arguments, environment);
  }

  /// Processes whose program lies in this test's bin/.
  int StagesAlive() const {
    int count = 0;
    for (const auto& entry : fs::directory_iterator("/proc")) {
      std::error_code error;
      const fs::path program = fs::read_symlink(entry.path() / "exe", error);
      count += !error && program.string().starts_with((root_ / "bin/keypose-").string());
    }
    return count;
  }
  static std::vector<pid_t> ChildrenOf(pid_t parent) {
    std::ifstream in("/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) +
                     "/children");
    std::vector<pid_t> children;
    for (pid_t child = 0; in >> child;) children.push_back(child);
    return children;
  }
  bool NoStageAliveSoon() const {
    for (int i = 0; i < 100 && StagesAlive() > 0; ++i) SleepSeconds(0.02);
    return StagesAlive() == 0;
  }
  /// Waits until a step runs (a program that runs with --describe does not count).
  bool WaitForStage() const {
    const auto at_work = [&] {
      return fs::exists(root_ / "hero/.keypose/tmp/gather.rest/made/log.txt");
    };
    for (int i = 0; i < 1000 && !at_work(); ++i) SleepSeconds(0.01);
    return at_work();
  }

  const fs::path root_ = path();
  bool mounted_ = false;
};

}  // namespace keypose::pipeline
