#include "pipeline/run/observer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace keypose::pipeline {
namespace {

/// A running stage is never shown as done: its results still have to be written and hashed.
constexpr double kAlmost = 0.99;
/// Progress above which a step's own pace is used.
constexpr double kUnderWay = 0.02;

}  // namespace

void Estimate::Begin(const Forecast& forecast) {
  steps_.clear();
  cores_ = std::max(1, forecast.cores);
  double sum = 0;
  int known = 0;
  for (const auto& [step, expected] : forecast.steps) {
    steps_[step].expected = expected;
    if (expected.seconds < 0) continue;
    sum += expected.seconds;
    ++known;
  }
  // A step of unknown duration is assumed to take the mean: better than no estimate for the whole
  // run.
  for (auto& [step, item] : steps_) {
    if (item.expected.seconds >= 0 || known == 0) continue;
    item.expected.seconds = sum / known;
    item.expected.measured = false;
  }
}

void Estimate::Started(const std::string& step, double now, int threads) {
  Item& item = steps_[step];
  item.begin = now;
  if (!item.expected.measured && item.expected.seconds >= 0)
    item.expected.seconds *= static_cast<double>(item.expected.threads) / std::max(1, threads);
  item.expected.threads = std::max(1, threads);
}

void Estimate::Progressed(const std::string& step, double fraction) {
  steps_[step].fraction = std::max(steps_[step].fraction, fraction);
}

void Estimate::Finished(const std::string& step, double seconds) {
  const auto it = steps_.find(step);
  if (it == steps_.end()) return;  // it was up to date from the start
  Item& item = it->second;
  if (!item.expected.measured && item.expected.seconds >= 0 && item.begin >= 0) {
    guessed_ += item.expected.seconds;
    took_ += seconds;
  }
  item.finished = true;
  item.expected.seconds = seconds;
}

int Estimate::finished() const {
  return static_cast<int>(std::count_if(steps_.begin(), steps_.end(),
                                        [](const auto& step) { return step.second.finished; }));
}

double Estimate::FractionOf(const std::string& step) const {
  const auto it = steps_.find(step);
  return it == steps_.end() ? 0 : std::min(kAlmost, it->second.fraction);
}

bool Estimate::AllKnown() const {
  return std::all_of(steps_.begin(), steps_.end(), [](const auto& step) {
    return step.second.finished || step.second.expected.seconds >= 0 ||
           step.second.fraction > kUnderWay;
  });
}

/// Ratio of real to guessed time over the finished steps; close to 1 while these were short.
double Estimate::Pace() const {
  constexpr double kDoubt = 5;  // [s] added to both real and guessed time
  return std::clamp((took_ + kDoubt) / (guessed_ + kDoubt), 0.1, 20.0);
}

double Estimate::Duration(const Item& item, double now, double pace) const {
  const double guess = item.expected.measured || item.finished ? item.expected.seconds
                                                               : item.expected.seconds * pace;
  if (item.begin < 0 || item.finished) return guess;
  const double elapsed = now - item.begin;
  // The weight of a step's own pace grows with its progress.
  const double own = item.fraction > kUnderWay ? elapsed / item.fraction : guess;
  const double before = guess >= 0 ? guess : own;
  return std::max(elapsed, (1 - item.fraction) * before + item.fraction * own);
}

double Estimate::Done(const Item& item, double now, double pace) const {
  const double duration = Duration(item, now, pace);
  if (item.finished) return duration;
  if (item.begin < 0) return 0;
  if (item.fraction > 0) return item.fraction * duration;
  return std::min(now - item.begin, 0.95 * duration);
}

double Estimate::Fraction(double now) const {
  const bool in_seconds = AllKnown();
  const double pace = Pace();
  double all = 0, done = 0;
  for (const auto& [step, item] : steps_) {
    const int threads = item.expected.threads;
    all += in_seconds ? threads * Duration(item, now, pace) : 1;
    const double share = item.finished ? 1 : item.fraction;
    done += in_seconds ? threads * Done(item, now, pace) : share;
  }
  if (finished() == total()) return 1;
  return all > 0 ? std::clamp(done / all, 0.0, kAlmost) : 0;
}

/// Seconds of the longest chain of unfinished steps that depend on each other.
double Estimate::LongestChain(double now, double pace) const {
  std::map<std::string, double> chains;
  const std::function<double(const std::string&)> chain = [&](const std::string& step) -> double {
    const auto it = steps_.find(step);
    if (it == steps_.end()) return 0;
    if (const auto known = chains.find(step); known != chains.end()) return known->second;
    double before = 0;
    for (const std::string& need : it->second.expected.needs)
      before = std::max(before, chain(need));
    return chains[step] = before + Duration(it->second, now, pace) - Done(it->second, now, pace);
  };
  double longest = 0;
  for (const auto& [step, item] : steps_) longest = std::max(longest, chain(step));
  return longest;
}

std::optional<double> Estimate::SecondsLeft(double now) const {
  if (!AllKnown()) return std::nullopt;
  const double pace = Pace();
  double work = 0;
  for (const auto& [step, item] : steps_) {
    const double left = Duration(item, now, pace) - Done(item, now, pace);
    work += left * std::min(item.expected.threads, cores_);
  }
  return std::max({0.0, work / cores_, LongestChain(now, pace)});
}

std::string DurationText(double seconds) {
  const long whole = std::lround(seconds);
  if (seconds < 9.95) return fmt::format("{:.1f} s", seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

}  // namespace keypose::pipeline
