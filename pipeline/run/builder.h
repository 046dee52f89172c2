// Runs the steps that a plan needs, in parallel within limits on cores and memory. Keeps the cache,
// the records and out/ consistent at all times.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/values/errors.h"
#include "pipeline/cache/ending.h"
#include "pipeline/disk/clock.h"
#include "pipeline/disk/process.h"
#include "pipeline/run/input_watch.h"
#include "pipeline/run/observer.h"
#include "pipeline/run/plan.h"
#include "pipeline/run/results_folder.h"

namespace keypose::pipeline {

struct Limits {
  int cores = 1;                  ///< all running steps together
  std::int64_t memory_bytes = 0;  ///< all running steps together; 0: no limit
  double load = 0;                ///< number of other programs that want a core
};

struct RunResult {
  ExitCode code = ExitCode::kOk;
  int made = 0, cached = 0;
  bool again = false;   ///< an input of a step changed while it ran: its results were dropped and a
                        ///< new plan is needed
  std::string message;  ///< of a failure: the step, its message, the path of its log, what to do
};

class Builder {
 public:
  /// Keeps references to all.
  Builder(Plan& plan, Workshop& workshop, ProcessRunner& processes, const Clock& clock,
          ResultsFolder& results, RunObserver& observer, const Limits& limits);

  /// Runs until nothing is left, a step fails (running steps finish first), or the user interrupts.
  /// @param record  its name, command and host are set; the rest is filled in, and the record is
  /// saved after every step
  /// @throws DiskError  the state folder cannot be written
  RunResult Run(RunRecord record);

 private:
  struct Running {
    int step = -1;
    int threads = 1;
    std::int64_t memory_bytes = 0;
    double begin = 0;
    Stamps before = {};  ///< of the step's inputs and programs
  };

  void Loop();
  Forecast MakeForecast() const;
  void EndRun();
  void ReportCached();
  void StartReady();
  bool MayStart(int step, std::int64_t memory) const;
  std::int64_t MemoryOf(int step) const;
  int ThreadsFor(int step, int ready) const;
  void Start(int step, int threads);
  std::vector<std::string> ArgumentsOf(int step);
  std::vector<std::filesystem::path> PathsOf(const Flow& flow, const PortFlows& port, int step);
  void Handle(const ProcessEvent& event);
  void Succeed(const Running& running, std::int64_t peak_bytes);
  bool WasSpoilt(const Running& running);
  void KeepOfFailure(int step, std::string& said);
  void Fail(const Running& running, int exit_code, const std::string& message);
  void Adopt(int step, bool made, double seconds, std::int64_t peak_bytes);
  void Publish(int step);
  std::string FailureMessage(int step, ExitCode code, int raw_code, const std::string& said) const;
  void AddToRecord(int step, const std::string& status, double seconds, std::int64_t peak_bytes);
  void Interrupt();
  void SaveRecord();

  std::filesystem::path WorkFolder(int step) const;
  std::filesystem::path FailedFolder(int step) const;

  Plan& plan_;
  Workshop& workshop_;
  ProcessRunner& processes_;
  const Clock& clock_;
  InputWatch watch_;
  ResultsFolder& results_;
  RunObserver& observer_;
  Limits limits_;
  RunRecord record_;
  RunResult result_;
  std::map<int, Running> running_;  ///< by process id
  std::vector<bool> reported_;      ///< steps whose artifact was adopted
};

/// A step id as a folder name.
std::string FolderName(const std::string& step_id);

}  // namespace keypose::pipeline
