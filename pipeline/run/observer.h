// The interface that receives a run's events, and the estimate of the time left.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/values/size_of.h"
#include "pipeline/cache/ending.h"

namespace keypose::pipeline {

/// What is known of a step before it runs.
struct Expected {
  double seconds = -1;  ///< negative: unknown
  /// measured by an earlier run; else a rough guess from the step's `cost`
  bool measured = true;
  int threads = 1;                      ///< expected number of threads
  std::vector<std::string> needs = {};  ///< steps of this run that must finish first
};

/// All steps that may run.
struct Forecast {
  std::map<std::string, Expected> steps;
  int cores = 1;
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

/// Percent done and time left, from earlier durations, the steps' `cost`, and their own progress.
/// Guessed durations are scaled by the ratio of real to guessed time over the finished steps.
class Estimate {
 public:
  void Begin(const Forecast& forecast);
  void Started(const std::string& step, double now, int threads);
  void Progressed(const std::string& step, double fraction);
  /// @param seconds  its duration; 0 if it was in the cache
  void Finished(const std::string& step, double seconds);

  /// Fraction of the whole run, in [0,1]; 1 only when all steps have finished. Measured in seconds
  /// if all durations are known, else in steps.
  double Fraction(double now) const;
  /// Nothing while no step's duration is known.
  std::optional<double> SecondsLeft(double now) const;
  int total() const { return SizeOf(steps_); }
  int finished() const;
  /// Fraction of a running step: below 1.
  double FractionOf(const std::string& step) const;

 private:
  struct Item {
    Expected expected;
    double begin = -1;  ///< negative: not started
    double fraction = 0;
    bool finished = false;
  };
  bool AllKnown() const;
  double Pace() const;
  double Duration(const Item& item, double now, double pace) const;
  double Done(const Item& item, double now, double pace) const;
  double LongestChain(double now, double pace) const;
  std::map<std::string, Item> steps_;
  int cores_ = 1;
  double guessed_ = 0, took_ = 0;  ///< [s], of finished steps that were guessed
};

/// "3 s", "2 min 05 s", "1 h 12 min"
std::string DurationText(double seconds);

}  // namespace keypose::pipeline
