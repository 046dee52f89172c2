// Stage programs as functions, with a memory disk and a clock that jumps to the next end of a
// process.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "pipeline/disk/process.h"
#include "pipeline/testing/memory_disk.h"

namespace keypose::pipeline {

/// One call of a stage, with its command line parsed.
struct FakeCall {
  std::string program;
  std::map<std::string, std::vector<std::string>> flags;
  std::map<std::string, std::string> environment;
  std::filesystem::path log;
  std::string Flag(const std::string& name) const {
    return flags.count(name) ? flags.at(name).front() : "";
  }
};

struct FakeStage {
  nlohmann::json describe;
  std::function<int(const FakeCall&, MemoryDisk&)> run;  ///< @return exit code
  double seconds = 1;
  std::int64_t peak_bytes = 1000;
  std::string refused = {};  ///< what --check_options says is wrong; empty: nothing
};

class FakeProcesses final : public ProcessRunner {
 public:
  FakeProcesses(MemoryDisk& disk, FakeClock& clock) : disk_(disk), clock_(clock) {}

  int Start(const Command& command) override;
  std::vector<ProcessEvent> Wait(double seconds) override;
  bool interrupted() const override { return interrupted_; }
  void StopAll() override { running_.clear(); }
  std::vector<Answer> Ask(const std::vector<std::vector<std::string>>& commands) override;
  std::optional<std::filesystem::path> FindTool(const std::string& name) const override;

  std::map<std::string, FakeStage> stages;             ///< by program path
  std::map<std::string, std::filesystem::path> tools;  ///< where external tools are
  std::vector<FakeCall> calls;                         ///< all started processes, in order
  int most_at_once = 0;
  int asked = 0;
  std::vector<std::vector<std::string>> checked;  ///< the command lines with --check_options
  int interrupt_after = -1;  ///< simulates an interrupt after this many processes have ended

 private:
  struct Process {
    FakeCall call;
    double end = 0;
  };
  MemoryDisk& disk_;
  FakeClock& clock_;
  std::map<int, Process> running_;
  int next_id_ = 1, ended_ = 0;
  bool interrupted_ = false;
};

}  // namespace keypose::pipeline
