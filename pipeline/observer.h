// Who is told of a run while it happens, and how long the rest will take.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/ending.h"

namespace keypose::pipeline {

/// What is known of a step before it runs.
struct Expected {
  double seconds = -1;  ///< negative: unknown
  /// by an earlier run; else from the step's `cost`, and known to within a factor only
  bool measured = true;
  int threads = 1;                      ///< that it will probably run on
  std::vector<std::string> needs = {};  ///< steps of this run that come before
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

/// Percent done and time left, from earlier durations, from what steps cost, and from the steps'
/// own progress. Steps that were only guessed are scaled by how far off the guesses of finished
/// ones were.
class Estimate {
 public:
  void Begin(const Forecast& forecast);
  void Started(const std::string& step, double now, int threads);
  void Progressed(const std::string& step, double fraction);
  /// @param seconds  it took; 0 when it was in the cache
  void Finished(const std::string& step, double seconds);

  /// Of the whole run, in [0,1], and 1 only when all is finished: of its seconds when all steps are
  /// known, else of its steps.
  double Fraction(double now) const;
  /// Nothing while of no step is anything known.
  std::optional<double> SecondsLeft(double now) const;
  int total() const { return static_cast<int>(steps_.size()); }
  int finished() const;
  /// Of a step that is at work: below 1.
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
