// Who is told of a run while it happens, and how long the rest will take.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace keypose::pipeline {

class RunObserver {
 public:
  virtual ~RunObserver() = default;
  /// @param expected_seconds  of every step that may run, from earlier runs; negative when there was none
  virtual void Begin(const std::map<std::string, double>& expected_seconds) = 0;
  virtual void Started(const std::string& step, const std::vector<std::string>& reasons, int threads) = 0;
  virtual void Progressed(const std::string& step, double fraction, const std::string& what) = 0;
  /// @param status  "made", "cached", "failed", "interrupted"
  virtual void Finished(const std::string& step, const std::string& status, double seconds) = 0;
  virtual void Note(const std::string& line) = 0;
  /// Called a few times a second.
  virtual void Tick() {}
  virtual void End() {}
};

/// Percent done and time left, from earlier durations and the steps' own progress.
class Estimate {
 public:
  void Begin(const std::map<std::string, double>& expected_seconds);
  void Started(const std::string& step, double now);
  void Progressed(const std::string& step, double fraction);
  /// @param seconds  it took; 0 when it was in the cache
  void Finished(const std::string& step, double seconds);

  /// Of the whole run, in [0,1]: of its seconds when all steps have run before, else of its steps.
  double Fraction(double now) const;
  /// Nothing while a step has neither run before nor got under way.
  std::optional<double> SecondsLeft(double now) const;
  int total() const { return static_cast<int>(steps_.size()); }
  int finished() const;
  double FractionOf(const std::string& step) const;

 private:
  struct Item {
    double expected = -1;
    double begin = -1;  ///< negative: not started
    double fraction = 0;
    bool finished = false;
  };
  bool Known(const Item& item) const;
  bool AllKnown() const;
  double Duration(const Item& item, double now) const;
  double Done(const Item& item, double now) const;
  std::map<std::string, Item> steps_;
};

/// "3 s", "2 min 05 s", "1 h 12 min"
std::string DurationText(double seconds);

}  // namespace keypose::pipeline
