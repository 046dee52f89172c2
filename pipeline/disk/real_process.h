// Linux processes. Each stage runs below a small guardian process, which stops everything that the
// stage started, even if the runner is killed.
#pragma once

#include <map>
#include <memory>

#include "pipeline/disk/process.h"

namespace keypose::pipeline {

class RealProcessRunner final : public ProcessRunner {
 public:
  /// @param catch_signals  handle SIGINT, SIGTERM and SIGHUP of the whole process; otherwise they
  /// end it at once
  explicit RealProcessRunner(bool catch_signals = false);
  ~RealProcessRunner() override;

  /// Every process started from now on keeps this descriptor (the project's lock) open until all
  /// its children have ended.
  void KeepOpen(int fd) { keep_open_ = fd; }

  int Start(const Command& command) override;
  std::vector<ProcessEvent> Wait(double seconds) override;
  bool interrupted() const override;
  void StopAll() override;
  std::vector<Answer> Ask(const std::vector<std::vector<std::string>>& commands) override;
  std::optional<std::filesystem::path> FindTool(const std::string& name) const override;

 private:
  struct Child;
  void ReadProgress(int id, Child& child, std::vector<ProcessEvent>* events);
  bool ReadResult(int id, Child& child, std::vector<ProcessEvent>* events);
  void PollOnce(int milliseconds, std::vector<ProcessEvent>* events);

  std::map<int, std::unique_ptr<Child>> children_;
  int next_id_ = 1;
  int keep_open_ = -1;
};

}  // namespace keypose::pipeline
