#include "pipeline/run/time_left.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace keypose::pipeline {
namespace {

/// A running stage is never shown as done: its results still have to be written and hashed.
constexpr double kAlmost = 0.99;
/// Progress of a step that is worth an observation.
constexpr double kPart = 0.1;
/// Of the logarithm of the time of a whole step.
constexpr double kWhole = 0.02;
/// How far progress is from even: half of a step's time may hide in its last tenth. It belongs to
/// the step, and goes with it.
constexpr double kUneven = 0.5 * 0.5;
/// One part may say that its step is this much slower than thought, as a logarithm.
constexpr double kMostTold = 3;
/// Of the load's logarithm, per second: a factor of 1.16 in a minute, 1.6 in ten.
constexpr double kDrift = 0.15 * 0.15 / 60;
/// Standard deviations on either side that hold four fifths of a normal distribution.
constexpr double kFourFifths = 1.28;

double Square(double x) { return x * x; }

/// Of the logarithm of real over expected time, beside load and machine.
double VarianceOf(Expected::From from) {
  switch (from) {
    case Expected::From::kOwnRun:
      return Square(0.15);
    case Expected::From::kSibling:
      return Square(0.35);
    case Expected::From::kCost:
      return Square(0.45);
    case Expected::From::kNothing:
      break;
  }
  return Square(1.2);
}

/// Of the logarithm of the time of a part of a step, in [0,1], over that share of its whole.
double PartVariance(double part) { return 0.03 / part; }

}  // namespace

void Slowness::Begin(double load, int cores) {
  // If all programs got equal shares, ours would take `shared` times as long. They may end at once,
  // or be such as give way: half of it is as likely as all of it.
  const double shared = std::log((std::max(0.0, load) + cores) / cores);
  running_.clear();
  mean_ = Eigen::Vector2d(shared / 2, 0);
  covariance_ =
      Eigen::Vector2d(Square(0.35) + Square(shared / 2), Square(0.6)).asDiagonal().toDenseMatrix();
}

void Slowness::Pass(double seconds) { covariance_(0, 0) += kDrift * std::max(0.0, seconds); }

void Slowness::Add(const std::string& step, double variance) {
  const Eigen::Index count = mean_.size();
  running_.push_back(step);
  mean_.conservativeResizeLike(Eigen::VectorXd::Zero(count + 1));
  covariance_.conservativeResizeLike(Eigen::MatrixXd::Zero(count + 1, count + 1));
  covariance_(count, count) = variance;
}

void Slowness::Remove(const std::string& step) {
  const auto it = std::find(running_.begin(), running_.end(), step);
  if (it == running_.end()) return;
  const Eigen::Index gone = 2 + (it - running_.begin()), after = mean_.size() - gone - 1;
  const Eigen::VectorXd mean = mean_.tail(after);
  mean_.segment(gone, after) = mean;
  mean_.conservativeResize(gone + after);
  const Eigen::MatrixXd below = covariance_.bottomRows(after);
  covariance_.middleRows(gone, after) = below;
  const Eigen::MatrixXd right = covariance_.rightCols(after);
  covariance_.middleCols(gone, after) = right;
  covariance_.conservativeResize(gone + after, gone + after);
  running_.erase(it);
}

Eigen::VectorXd Slowness::RowOf(const Of& of) const {
  Eigen::VectorXd row = Eigen::VectorXd::Zero(mean_.size());
  row(0) = 1;
  row(1) = of.guessed ? 1 : 0;
  const auto it = std::find(running_.begin(), running_.end(), of.step);
  if (it != running_.end()) row(2 + (it - running_.begin())) = 1;
  return row;
}

double Slowness::VarianceOf(const std::vector<std::pair<Of, double>>& weighted) const {
  Eigen::VectorXd row = Eigen::VectorXd::Zero(mean_.size());
  for (const auto& [of, weight] : weighted) row += weight * RowOf(of);
  return row.dot(covariance_ * row);
}

void Slowness::Observe(const Of& of, double log_ratio, double variance, bool is_end) {
  const Eigen::VectorXd row = RowOf(of);
  const double surprise = log_ratio - row.dot(mean_);
  const double expected = row.dot(covariance_ * row) + variance;
  // This is no chance: the load has changed, and its past tells little.
  constexpr double kDeviations = 2.5;
  if (is_end && Square(surprise) > Square(kDeviations) * expected)
    covariance_(0, 0) += Square(surprise) / 4;
  const Eigen::VectorXd to_row = covariance_ * row;
  const Eigen::VectorXd gain = to_row / (row.dot(to_row) + variance);
  mean_ += gain * surprise;
  covariance_ -= gain * to_row.transpose();
}

void TimeLeft::Begin(const Forecast& forecast, double now) {
  steps_.clear();
  cores_ = std::max(1, forecast.cores);
  for (const auto& [step, expected] : forecast.steps) steps_[step].expected = expected;
  slowness_.Begin(forecast.load, cores_);
  passed_ = now;
}

void TimeLeft::Started(const std::string& step, double now, int threads) {
  Item& item = steps_[step];
  item.begin = item.said = now;
  item.learned = {now, 0};
  item.fraction = 0;
  item.finished = false;
  Expected& expected = item.expected;
  if (expected.from == Expected::From::kCost && expected.seconds >= 0)
    expected.seconds *= static_cast<double>(expected.threads) / std::max(1, threads);
  expected.threads = std::max(1, threads);
  slowness_.Remove(step);
  slowness_.Add(step, VarianceOf(expected.from) + kUneven);
}

bool TimeLeft::Guessed(const Item& item) { return item.expected.from == Expected::From::kCost; }

Slowness::Of TimeLeft::FactorsOf(const std::string& step, const Item& item) const {
  return {Guessed(item), item.AtWork() ? step : ""};
}

/// From the time that a part of a step took, what it tells of load, machine and step.
void TimeLeft::Learn(const std::string& step, double now, double fraction) {
  Item& item = steps_[step];
  slowness_.Pass(now - passed_);
  passed_ = std::max(passed_, now);
  const double part = fraction - item.learned.fraction;
  const double real = std::max(0.05, now - item.learned.time);
  const double expected = part * ExpectedSeconds(item);
  item.learned = {now, fraction};
  if (expected <= 0) return;
  const Slowness::Of of = FactorsOf(step, item);
  // Progress is not linear: a part may take several times as long as the next.
  const double mean = slowness_.Mean(of);
  const double ratio = std::clamp(std::log(real / expected), mean - kMostTold, mean + kMostTold);
  slowness_.Observe(of, ratio, PartVariance(part) + Square(0.5 / real));
}

void TimeLeft::Progressed(const std::string& step, double now, double fraction) {
  const auto it = steps_.find(step);
  if (it == steps_.end() || !it->second.AtWork() || fraction <= it->second.fraction) return;
  Item& item = it->second;
  item.fraction = std::min(1.0, fraction);
  item.said = now;
  if (item.fraction - item.learned.fraction >= kPart) Learn(step, now, item.fraction);
}

void TimeLeft::Finished(const std::string& step, double now, const std::string& status) {
  const auto it = steps_.find(step);
  if (it == steps_.end()) return;  // it was up to date from the start
  Item& item = it->second;
  slowness_.Remove(step);
  if (item.AtWork() && status == "made") {
    item.took = now - item.begin;
    slowness_.Pass(now - passed_);
    passed_ = std::max(passed_, now);
    const double expected = ExpectedSeconds(item), real = std::max(0.05, item.took);
    // A program's start and end take a moment that says nothing.
    const double variance = VarianceOf(item.expected.from) + kWhole + Square(0.5 / real);
    if (expected > 0) slowness_.Observe({Guessed(item), ""}, std::log(real / expected), variance);
  }
  item.finished = true;
}

int TimeLeft::finished() const {
  return static_cast<int>(std::count_if(steps_.begin(), steps_.end(),
                                        [](const auto& step) { return step.second.finished; }));
}

double TimeLeft::FractionOf(const std::string& step) const {
  const auto it = steps_.find(step);
  return it == steps_.end() ? 0 : std::min(kAlmost, it->second.fraction);
}

/// A step of which nothing is known is assumed to take the mean of the others. Negative: nothing is
/// known of any.
double TimeLeft::ExpectedSeconds(const Item& item) const {
  if (item.expected.seconds >= 0) return item.expected.seconds;
  double sum = 0;
  int known = 0;
  for (const auto& [step, other] : steps_) {
    const bool made = other.finished && other.took > 0;
    if (other.expected.seconds < 0 && !made) continue;
    sum += other.expected.seconds < 0 ? other.took : other.expected.seconds;
    ++known;
  }
  return known > 0 ? sum / known : -1;
}

/// What the running steps' silence says beside what they said: had they been as fast as thought,
/// the next part would be done.
Slowness TimeLeft::WithSilence(double now) const {
  Slowness slowness = slowness_;
  slowness.Pass(now - passed_);
  for (const auto& [step, item] : steps_) {
    if (!item.AtWork()) continue;
    const double whole = ExpectedSeconds(item);
    if (whole <= 0) continue;
    const auto later = [&](const Slowness::Of& of, double part, double since, double variance) {
      const double real = now - since, expected = part * whole;
      if (real > expected * std::exp(slowness.Mean(of)))
        slowness.Observe(of, std::log(real / expected), variance, false);
    };
    later({Guessed(item), ""}, 1, item.begin, VarianceOf(item.expected.from) + kWhole);
    const double rest = 1 - item.learned.fraction;
    // A step that has never told its progress may do so only at its end.
    const double part =
        item.fraction > 0 ? std::min(rest, item.fraction - item.learned.fraction + kPart) : rest;
    if (part > 0) later(FactorsOf(step, item), part, item.learned.time, PartVariance(part));
  }
  return slowness;
}

TimeLeft::Rest TimeLeft::RestOf(const std::string& step, const Item& item, double now,
                                const Slowness& slowness) const {
  const double expected = ExpectedSeconds(item);
  if (item.finished || expected < 0) return {};
  Rest rest{expected * std::exp(slowness.Mean(FactorsOf(step, item))), 0};
  if (!item.AtWork()) return {rest.seconds, VarianceOf(item.expected.from)};
  // Since it last said something it has gone on; but the longer it is silent beyond what was
  // expected, the longer it will be.
  const double after_word = (1 - item.fraction) * rest.seconds, silent = now - item.said;
  const double thought =
      (1 - item.fraction) * expected * std::exp(slowness_.Mean(FactorsOf(step, item)));
  const double doubtful = 0.15 * std::min(silent, thought) + 0.5 * std::max(0.0, silent - thought);
  rest.own_variance = PartVariance(std::max(0.05, 1 - item.fraction));
  if (doubtful > after_word - silent) rest.own_variance += Square(0.6);
  rest.seconds = std::max(after_word - silent, doubtful);
  return rest;
}

std::map<std::string, TimeLeft::Rest> TimeLeft::Rests(double now, const Slowness& slowness) const {
  std::map<std::string, Rest> rests;
  for (const auto& [step, item] : steps_) rests[step] = RestOf(step, item, now, slowness);
  return rests;
}

/// Seconds of the longest chain of unfinished steps that depend on each other.
double TimeLeft::LongestChain(const std::map<std::string, Rest>& rests) const {
  std::map<std::string, double> chains;
  const std::function<double(const std::string&)> chain = [&](const std::string& step) -> double {
    const auto it = steps_.find(step);
    if (it == steps_.end()) return 0;
    if (const auto known = chains.find(step); known != chains.end()) return known->second;
    double before = 0;
    for (const std::string& need : it->second.expected.needs)
      before = std::max(before, chain(need));
    return chains[step] = before + rests.at(step).seconds;
  };
  double longest = 0;
  for (const auto& [step, item] : steps_) longest = std::max(longest, chain(step));
  return longest;
}

double TimeLeft::Fraction(double now) const {
  if (finished() == total()) return 1;
  const bool in_seconds = Left(now).has_value();
  const auto rests = Rests(now, WithSilence(now));
  double all = 0, done = 0;
  for (const auto& [step, item] : steps_) {
    const double threads = item.expected.threads;
    const double spent = item.AtWork() ? now - item.begin : item.took;
    done += in_seconds ? threads * spent : item.finished ? 1 : item.fraction;
    all += in_seconds ? threads * (spent + rests.at(step).seconds) : 1;
  }
  return all > 0 ? std::clamp(done / all, 0.0, kAlmost) : 0;
}

std::optional<SecondsLeft> TimeLeft::Left(double now) const {
  const Slowness slowness = WithSilence(now);
  const auto rests = Rests(now, slowness);
  std::vector<std::pair<Slowness::Of, double>> weighted;
  double work = 0, own = 0;
  for (const auto& [step, item] : steps_) {
    if (item.finished) continue;
    if (ExpectedSeconds(item) < 0) return std::nullopt;
    const Rest& rest = rests.at(step);
    const double share = rest.seconds * std::min(item.expected.threads, cores_);
    weighted.push_back({FactorsOf(step, item), share});
    work += share;
    own += Square(share) * rest.own_variance;
  }
  if (work <= 0) return SecondsLeft{};
  const double likely = std::max(work / cores_, LongestChain(rests));
  const double variance =
      Square(0.08) + (own + slowness.VarianceOf(weighted)) / Square(work) + kDrift * likely / 3;
  const double factor = std::exp(kFourFifths * std::sqrt(variance));
  return SecondsLeft{likely / factor, likely, likely * factor};
}

std::string DurationText(double seconds) {
  const long whole = std::lround(seconds);
  if (seconds < 9.95) return fmt::format("{:.1f} s", seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

namespace {

struct Rounded {
  long number;
  std::string text, unit;  ///< without and of the unit
};

/// To 5 seconds, minutes, or 10 minutes; never zero.
Rounded RoundedText(double seconds) {
  if (seconds < 57.5) {
    const long number = std::max(5L, 5 * std::lround(seconds / 5));
    return {number, fmt::format("{}", number), "s"};
  }
  if (seconds < 59.5 * 60) {
    const long number = std::max(1L, std::lround(seconds / 60));
    return {60 * number, fmt::format("{}", number), "min"};
  }
  const long tens = std::max(6L, std::lround(seconds / 600));
  if (tens % 6 == 0) return {600 * tens, fmt::format("{}", tens / 6), "h"};
  return {600 * tens, fmt::format("{} h {}", tens / 6, tens % 6 * 10), "min"};
}

}  // namespace

std::string RangeText(const SecondsLeft& left) {
  constexpr double kWellKnown = 1.35;
  if (left.high <= kWellKnown * left.low) return DurationText(left.likely);
  const Rounded low = RoundedText(left.low), high = RoundedText(left.high);
  if (low.number == high.number) return fmt::format("about {} {}", high.text, high.unit);
  if (low.unit == high.unit && high.number < 3600)
    return fmt::format("{} to {} {}", low.text, high.text, high.unit);
  return fmt::format("{} {} to {} {}", low.text, low.unit, high.text, high.unit);
}

}  // namespace keypose::pipeline
