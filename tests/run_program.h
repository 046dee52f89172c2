// Runs the built programs as a user would, for tests.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace keypose::tests {

struct RunResult {
  /// 128 + signal if a signal ended it; -1 if it exceeded the limit and was killed
  int exit_code = -1;
  std::string output;  ///< standard output and error together
};

/// A child process in its own process group.
class Program {
 public:
  /// @param command      program and arguments; a first word without '/' is searched in this build,
  /// then in PATH
  /// @param environment  "NAME=value" entries that replace or extend this process's
  Program(const std::vector<std::string>& command, const std::filesystem::path& folder,
          const std::vector<std::string>& environment = {});
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Sends the signal to the whole group, like a terminal on Ctrl-C.
  void SendSignal(int signal) const;
  /// Waits until the output so far contains `text`.
  /// @return false if the program ended, or after `seconds`
  bool WaitForOutput(const std::string& text, double seconds);
  bool running();
  RunResult Wait(double seconds = 300);

 private:
  void Read(int milliseconds);

  pid_t pid_ = -1;
  int pipe_ = -1;
  bool ended_ = false;
  RunResult result_;
};

RunResult RunProgram(const std::vector<std::string>& command, const std::filesystem::path& folder,
                     const std::vector<std::string>& environment = {}, double seconds = 300);

/// Whether a program is built here or on PATH.
bool HasProgram(const std::string& name);

}  // namespace keypose::tests
