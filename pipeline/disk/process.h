// The runner's interface to processes: start a stage, receive its progress and end, stop all, run a
// short program and read its output.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace keypose::pipeline {

struct Command {
  std::vector<std::string> arguments;    ///< [0] is the program
  std::vector<std::string> environment;  ///< "NAME=VALUE", added to the runner's own
  std::filesystem::path folder;          ///< where it runs
  std::filesystem::path log;             ///< takes its standard output and error
};

struct ProcessEvent {
  enum class Kind { kProgress, kFinished };
  Kind kind = Kind::kFinished;
  int id = 0;
  double fraction = 0;  ///< kProgress: of the whole stage, in [0,1]
  std::string what;     ///< kProgress: a few words
  int exit_code = 0;    ///< kFinished: 128 + signal if a signal ended it
  std::int64_t peak_bytes = 0;
};

class ProcessRunner {
 public:
  struct Answer {
    int exit_code = 0;
    std::string output;  ///< standard output
    std::string error;
  };

  virtual ~ProcessRunner() = default;
  /// @return an id for the events @throws DiskError  the log cannot be written
  virtual int Start(const Command& command) = 0;
  /// The events so far. Waits up to `seconds` for the first one; returns early when interrupted.
  virtual std::vector<ProcessEvent> Wait(double seconds) = 0;
  /// Whether the user interrupted the run.
  virtual bool interrupted() const = 0;
  /// Terminates all started programs, kills those that do not end within a few seconds, and returns
  /// when none is left.
  virtual void StopAll() = 0;
  /// Runs short programs in parallel. Exit code 127: could not be started; 124: took over a minute.
  virtual std::vector<Answer> Ask(const std::vector<std::vector<std::string>>& commands) = 0;
  /// The path of an external tool: the value of KEYPOSE_<NAME> or the first on PATH.
  virtual std::optional<std::filesystem::path> FindTool(const std::string& name) const = 0;
};

}  // namespace keypose::pipeline
