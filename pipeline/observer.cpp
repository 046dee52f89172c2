#include "pipeline/observer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace keypose::pipeline {

void Estimate::Begin(const std::map<std::string, double>& expected_seconds) {
  steps_.clear();
  for (const auto& [step, seconds] : expected_seconds) steps_[step].expected = seconds;
}

void Estimate::Started(const std::string& step, double now) { steps_[step].begin = now; }
void Estimate::Progressed(const std::string& step, double fraction) { steps_[step].fraction = std::max(steps_[step].fraction, fraction); }

void Estimate::Finished(const std::string& step, double seconds) {
  const auto it = steps_.find(step);
  if (it == steps_.end()) return;  // it was up to date from the start
  it->second.finished = true;
  it->second.expected = seconds;
}

int Estimate::finished() const {
  return static_cast<int>(std::count_if(steps_.begin(), steps_.end(), [](const auto& step) { return step.second.finished; }));
}

double Estimate::FractionOf(const std::string& step) const {
  const auto it = steps_.find(step);
  return it == steps_.end() ? 0 : it->second.fraction;
}

bool Estimate::Known(const Item& item) const { return item.finished || item.expected >= 0 || item.fraction > 0.02; }

bool Estimate::AllKnown() const {
  return std::all_of(steps_.begin(), steps_.end(), [&](const auto& step) { return Known(step.second); });
}

double Estimate::Duration(const Item& item, double now) const {
  if (item.begin < 0 || item.finished) return item.expected;
  const double elapsed = now - item.begin;
  // The further a step is, the more its own pace counts.
  const double pace = item.fraction > 0.02 ? elapsed / item.fraction : item.expected;
  const double expected = item.expected >= 0 ? item.expected : pace;
  return std::max(elapsed, (1 - item.fraction) * expected + item.fraction * pace);
}

double Estimate::Done(const Item& item, double now) const {
  const double duration = Duration(item, now);
  if (item.finished) return duration;
  if (item.begin < 0) return 0;
  if (item.fraction > 0) return item.fraction * duration;
  return std::min(now - item.begin, 0.95 * duration);
}

double Estimate::Fraction(double now) const {
  double all = 0, done = 0;
  const bool in_seconds = AllKnown();
  for (const auto& [step, item] : steps_) {
    all += in_seconds ? Duration(item, now) : 1;
    done += in_seconds ? Done(item, now) : item.finished ? 1 : item.fraction;
  }
  return all > 0 ? std::clamp(done / all, 0.0, 1.0) : 1;
}

std::optional<double> Estimate::SecondsLeft(double now) const {
  if (!AllKnown()) return std::nullopt;
  double left = 0;
  int running = 0;
  for (const auto& [step, item] : steps_) {
    left += Duration(item, now) - Done(item, now);
    running += item.begin >= 0 && !item.finished;
  }
  return std::max(0.0, left / std::max(1, running));
}

std::string DurationText(double seconds) {
  const long whole = std::lround(seconds);
  if (seconds < 9.95) return fmt::format("{:.1f} s", seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

}  // namespace keypose::pipeline
