// The interface that receives a run's events.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "pipeline/cache/ending.h"

namespace keypose::pipeline {

/// What is known of a step before it runs.
struct Expected {
  /// what its duration is taken from: its own last run, the same step on another pose, the `cost`
  /// of the pipeline file
  enum class From { kNothing, kOwnRun, kSibling, kCost };
  From from = From::kNothing;
  double seconds = -1;                  ///< negative: unknown
  int threads = 1;                      ///< expected number of threads
  std::vector<std::string> needs = {};  ///< steps of this run that must finish first
};

/// All steps that may run.
struct Forecast {
  std::map<std::string, Expected> steps;
  int cores = 1;
  double load = 0;  ///< number of other programs that want a core
};

class RunObserver {
 public:
  virtual ~RunObserver() = default;
  virtual void Begin(const Forecast& forecast) = 0;
  virtual void Started(const std::string& step, const std::vector<std::string>& reasons,
                       int threads) = 0;
  virtual void Progressed(const std::string& step, double fraction, const std::string& what) = 0;
  /// @param status  "made", "cached", "failed", "interrupted"
  virtual void Finished(const std::string& step, const std::string& status, double seconds) = 0;
  virtual void Note(const std::string& line) = 0;
  /// Called a few times a second.
  virtual void Tick() {}
  virtual void End(const Ending&) {}
};

}  // namespace keypose::pipeline
