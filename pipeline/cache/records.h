// The history: the last record of every step, and one record per run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipeline/cache/ending.h"
#include "pipeline/cache/fingerprint.h"
#include "pipeline/disk/disk.h"

namespace keypose::pipeline {

/// How a step last ended.
struct StepRecord {
  std::string fingerprint;  ///< of the last success; empty if there was none
  Recipe recipe;            ///< of the last success
  double seconds = 0;       ///< of the last success
  std::int64_t peak_bytes = 0;
  double when = 0;                   ///< time of the last end [s since 1970]
  std::vector<std::string> reasons;  ///< why it last ran
  bool found = false;                ///< it was found in the cache and did not run
  bool failed = false;               ///< the last try failed
  int exit_code = 0;                 ///< of that failure
  std::string failed_fingerprint;
  std::string error;  ///< its message
};

/// One line of a run record.
struct RunStep {
  std::string id, status;  ///< "made", "cached", "failed", "interrupted"
  std::string fingerprint;
  double seconds = 0;
  std::int64_t peak_bytes = 0;
  std::vector<std::string> reasons;
};

struct RunRecord {
  std::string name;  ///< file name without extension: UTC time and process id
  double begin = 0, end = 0;
  std::string command, host;
  int exit_code = 0;
  std::vector<RunStep> steps;
  Ending ending;
};

class Records {
 public:
  Records(Disk& disk, std::filesystem::path state_folder);
  std::optional<StepRecord> Last(const std::string& step_id) const;
  void SetLast(const std::string& step_id, const StepRecord& record);
  void Save(const RunRecord& run);
  /// Fingerprints in the newest `runs` run records, and those of these steps' last successes.
  std::set<std::string> Mentioned(int runs, const std::set<std::string>& steps) const;
  /// Removes the last records of all steps but these.
  void ForgetStepsOutside(const std::set<std::string>& steps);
  /// Removes all but the newest `runs` run records.
  /// @return number of removed records
  int DropOldRuns(int runs);

 private:
  std::filesystem::path StepFile(const std::string& step_id) const;
  /// The steps that have a last record.
  std::vector<std::string> Steps() const;
  Disk& disk_;
  std::filesystem::path state_folder_;
};

/// "2026-03-01 14:05:09 UTC"
std::string TimeText(double seconds_since_1970);

}  // namespace keypose::pipeline
