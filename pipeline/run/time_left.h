// How far a run is, and how long it still takes: a range, learned from what the run does.
//
// Each step's duration is expected from its own last run, from the same step on another pose, or
// from the `cost` of the pipeline file. What is expected is wrong by factors that all steps share:
// other programs want the cores (the load, which changes while the run goes on), and this machine
// is not the one on which `cost` was measured; and by one of each step's own. A Kalman filter on
// the logarithms of these factors learns them from every tenth of a step's progress, and from
// silence: a step that should have ended by now says as much as one that ended late. What it does
// not know is the range.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/values/size_of.h"
#include "pipeline/run/observer.h"

namespace keypose::pipeline {

/// How many times longer than expected steps take: logarithms of the factors of the load, of the
/// machine against that of `cost`, and of each running step itself.
class Slowness {
 public:
  /// What a step's factor is made of.
  struct Of {
    bool guessed = false;   ///< expected from `cost`, so that the machine's factor is in it
    std::string step = {};  ///< if it is at work, its own factor is in it
  };
  /// @param load  number of other programs that wanted a core when the run began, >= 0
  void Begin(double load, int cores);
  /// The load may change while seconds pass.
  void Pass(double seconds);
  /// @param variance  of the logarithm of its own factor
  void Add(const std::string& step, double variance);
  /// What is not known of a step's own factor is forgotten with it.
  void Remove(const std::string& step);
  /// @param log_ratio  of real to expected time
  /// @param is_end     of a part that has ended; else of one that goes on, whose silence may have
  /// other reasons than a load that has changed
  void Observe(const Of& of, double log_ratio, double variance, bool is_end = true);
  /// Logarithm of the factor on an expected time.
  double Mean(const Of& of) const { return RowOf(of).dot(mean_); }
  /// Of the sum of factors with these weights.
  double VarianceOf(const std::vector<std::pair<Of, double>>& weighted) const;

 private:
  Eigen::VectorXd RowOf(const Of& of) const;
  std::vector<std::string> running_;  ///< their factors come after the first two
  Eigen::VectorXd mean_;
  Eigen::MatrixXd covariance_;
};

/// [s]; four runs of five end between `low` and `high`.
struct SecondsLeft {
  double low = 0, likely = 0, high = 0;
};

class TimeLeft {
 public:
  void Begin(const Forecast& forecast, double now);
  void Started(const std::string& step, double now, int threads);
  void Progressed(const std::string& step, double now, double fraction);
  /// @param status  as of RunObserver::Finished; only what was made tells of the machine
  void Finished(const std::string& step, double now, const std::string& status);

  /// Fraction of the whole run, in [0,1]; 1 only when all steps have finished. Measured in seconds
  /// if all durations are known, else in steps.
  double Fraction(double now) const;
  /// Nothing while nothing is known of a step. Grows, too, where a step takes longer than expected.
  std::optional<SecondsLeft> Left(double now) const;
  int total() const { return SizeOf(steps_); }
  int finished() const;
  /// Fraction of a running step: below 1.
  double FractionOf(const std::string& step) const;

 private:
  struct Mark {
    double time = 0, fraction = 0;
  };
  struct Item {
    Expected expected;
    double begin = -1;              ///< negative: not started
    Mark learned;                   ///< from what came before this, the filter has learned
    double fraction = 0, said = 0;  ///< what it said last, and when
    double took = 0;
    bool finished = false;
    bool AtWork() const { return begin >= 0 && !finished; }
  };
  /// Of one unfinished step.
  struct Rest {
    double seconds = 0;
    double own_variance = 0;  ///< of its logarithm, beside what the filter knows
  };

  void Learn(const std::string& step, double now, double fraction);
  Slowness WithSilence(double now) const;
  double ExpectedSeconds(const Item& item) const;
  static bool Guessed(const Item& item);
  Slowness::Of FactorsOf(const std::string& step, const Item& item) const;
  Rest RestOf(const std::string& step, const Item& item, double now,
              const Slowness& slowness) const;
  double LongestChain(const std::map<std::string, Rest>& rests) const;
  std::map<std::string, Rest> Rests(double now, const Slowness& slowness) const;

  std::map<std::string, Item> steps_;
  int cores_ = 1;
  Slowness slowness_;
  double passed_ = 0;  ///< the time to which slowness_ has been moved on
};

/// "3 s", "2 min 05 s", "1 h 12 min"
std::string DurationText(double seconds);

/// "2 min 05 s" where it is known well, else "2 to 5 min", "40 s to 2 min", "1 h to 2 h 30 min".
std::string RangeText(const SecondsLeft& left);

}  // namespace keypose::pipeline
