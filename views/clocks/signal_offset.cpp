#include "views/clocks/signal_offset.h"

#include <algorithm>
#include <cmath>

#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "views/clocks/correlation.h"

namespace keypose {
namespace {

constexpr double kWholeEnergy = 0.1;  // of the signal, that is added to the overlap's
constexpr double kThirdsReach_s = 2;  // about the offset of the whole
constexpr double kMostDrift_s = 0.3;  // of a third from the whole
constexpr double kSame = 0.9999;      // correlation; Fisher's measure of 1 is infinite
constexpr double kLikely = 2.0 / 3;   // of the sigmas of what is sure
constexpr double kLeastThird_s = 4;

/// sums[i]: of the first i values.
std::vector<double> RunningSums(const std::vector<double>& values, bool squared) {
  std::vector<double> sums(values.size() + 1, 0);
  for (std::size_t i = 0; i < values.size(); ++i)
    sums[i + 1] = sums[i] + (squared ? values[i] * values[i] : values[i]);
  return sums;
}

/// Without what changes slowly: the mean of so many values about each is taken away.
std::vector<double> WithoutTrend(const std::vector<double>& values, int width) {
  const std::vector<double> sums = RunningSums(values, false);
  const int count = SizeOf(values), half = std::max(1, width / 2);
  std::vector<double> fast(values.size());
  for (int i = 0; i < count; ++i) {
    const int begin = std::max(0, i - half), end = std::min(count, i + half + 1);
    fast[i] = values[i] - (sums[end] - sums[begin]) / (end - begin);
  }
  return fast;
}

/// Correlation at each lag that leaves enough in common.
class Lags {
 public:
  Lags(const Signal& a, const Signal& b, const OffsetOptions& options)
      : rate_(a.per_second), start_s_(b.first_s - a.first_s) {
    const int width = static_cast<int>(options.trend_s * rate_);
    const std::vector<double> fast_a = WithoutTrend(a.values, width),
                              fast_b = WithoutTrend(b.values, width);
    count_a_ = SizeOf(fast_a), count_b_ = SizeOf(fast_b);
    scores_ = CrossCorrelation(fast_a, fast_b);
    least_ = std::max(2, std::min(static_cast<int>(options.least_overlap_s * rate_),
                                  std::min(count_a_, count_b_) / 2));
    Normalise(RunningSums(fast_a, true), RunningSums(fast_b, true));
  }

  int size() const { return SizeOf(scores_); }
  double score(int i) const { return scores_[i]; }
  /// Of a lag that may lie between two.
  double OffsetOf(double i) const { return start_s_ + (i - (count_a_ - 1)) / rate_; }
  double rate() const { return rate_; }
  bool Allowed(int i) const { return End(i) - Begin(i) >= least_; }
  /// What of a is in common, [Begin, End).
  int Begin(int i) const { return std::max(0, count_a_ - 1 - i); }
  int End(int i) const { return std::min(count_a_, count_b_ + count_a_ - 1 - i); }

 private:
  void Normalise(const std::vector<double>& energy_a, const std::vector<double>& energy_b) {
    const double whole_a = energy_a.back(), whole_b = energy_b.back();
    for (int i = 0; i < size(); ++i) {
      const int lag = i - (count_a_ - 1);
      if (!Allowed(i)) {
        scores_[i] = 0;
        continue;
      }
      const double part_a = energy_a[End(i)] - energy_a[Begin(i)];
      const double part_b = energy_b[End(i) + lag] - energy_b[Begin(i) + lag];
      const double norm =
          std::sqrt((part_a + kWholeEnergy * whole_a) * (part_b + kWholeEnergy * whole_b));
      scores_[i] = norm > 0 ? (1 + kWholeEnergy) * scores_[i] / norm : 0;
    }
  }

  double rate_, start_s_;
  int count_a_ = 0, count_b_ = 0, least_ = 0;
  std::vector<double> scores_;
};

/// How far a peak reaches to one side before it has fallen to half its height.
int HalfWidth(const Lags& lags, int peak, int step) {
  int width = 0;
  for (int i = peak; i >= 0 && i < lags.size() && lags.score(i) > 0.5 * lags.score(peak); i += step)
    ++width;
  return width;
}

/// Where a parabola through a peak and its neighbours is highest.
double Refined(const Lags& lags, int peak) {
  if (peak < 1 || peak + 1 >= lags.size()) return peak;
  const double before = lags.score(peak - 1), at = lags.score(peak), after = lags.score(peak + 1);
  const double bend = before - 2 * at + after;
  return bend < 0 ? peak + std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : peak;
}

void Judge(const Lags& lags, const std::vector<int>& looked_at, int peak,
           const OffsetOptions& options, ClockOffset* offset) {
  const int apart = std::max({static_cast<int>(options.apart_s * lags.rate()),
                              2 * HalfWidth(lags, peak, -1), 2 * HalfWidth(lags, peak, 1)});
  double squares = 0;
  int others = 0;
  for (const int i : looked_at) {
    if (std::abs(i - peak) <= apart) continue;
    offset->second_peak = std::max(offset->second_peak, lags.score(i));
    squares += lags.score(i) * lags.score(i);
    ++others;
  }
  const double spread = others > 0 ? std::sqrt(squares / others) : 0;
  offset->sigmas = spread > 0 ? std::atanh(std::min(offset->peak, kSame)) / spread : 0;
  const bool stands_out = others > 0 && offset->peak >= options.least_peak &&
                          offset->peak >= options.least_ratio * offset->second_peak;
  offset->confident = stands_out && offset->sigmas >= options.least_sigmas;
  offset->likely = stands_out && offset->sigmas >= kLikely * options.least_sigmas;
}

/// What lies between two times.
Signal Part(const Signal& signal, double begin_s, double end_s) {
  const auto at = [&](double time_s) {
    const double i = std::round((time_s - signal.first_s) * signal.per_second);
    return static_cast<std::ptrdiff_t>(
        std::clamp(i, 0.0, static_cast<double>(signal.values.size())));
  };
  const std::ptrdiff_t begin = at(begin_s), end = std::max(begin, at(end_s));
  Signal part{
      signal.first_s + static_cast<double>(begin) / signal.per_second, signal.per_second, {}};
  part.values.assign(signal.values.begin() + begin, signal.values.begin() + end);
  return part;
}

/// The offset in a part of the first signal, near that of the whole.
ClockOffset OffsetWithin(const Signal& a, const Signal& b, const OffsetOptions& options,
                         double whole_s, double begin_s, double end_s) {
  const Signal part_a = Part(a, begin_s, end_s);
  const Signal part_b =
      Part(b, begin_s + whole_s - kThirdsReach_s, end_s + whole_s + kThirdsReach_s);
  return CorrelateSignals(part_a, part_b, options, whole_s, kThirdsReach_s);
}

/// A third in which something else looks more alike tells nothing.
bool Near(const ClockOffset& third, double whole_s) {
  return third.confident && std::abs(third.seconds - whole_s) <= kMostDrift_s;
}

}  // namespace

ClockOffset CorrelateSignals(const Signal& a, const Signal& b, const OffsetOptions& options,
                             double near_s, double reach_s) {
  if (!(a.per_second > 0) || a.per_second != b.per_second)
    throw UsageError("signals are compared at one rate");
  ClockOffset offset;
  if (a.values.empty() || b.values.empty()) return offset;
  const Lags lags(a, b, options);
  std::vector<int> looked_at;
  for (int i = 0; i < lags.size(); ++i)
    if (lags.Allowed(i) && (reach_s < 0 || std::abs(lags.OffsetOf(i) - near_s) <= reach_s))
      looked_at.push_back(i);
  if (looked_at.empty()) return offset;
  const int peak = *std::max_element(looked_at.begin(), looked_at.end(),
                                     [&](int i, int j) { return lags.score(i) < lags.score(j); });
  offset.seconds = lags.OffsetOf(Refined(lags, peak));
  offset.peak = lags.score(peak);
  offset.overlap_s = (lags.End(peak) - lags.Begin(peak)) / a.per_second;
  offset.middle_s = a.first_s + 0.5 * (lags.Begin(peak) + lags.End(peak)) / a.per_second;
  Judge(lags, looked_at, peak, options, &offset);
  return offset;
}

ClockDrift CorrelateDrifting(const Signal& a, const Signal& b, const OffsetOptions& options) {
  ClockDrift drift;
  drift.whole = CorrelateSignals(a, b, options);
  const double third = drift.whole.overlap_s / 3, begin = drift.whole.middle_s - 1.5 * third;
  if (!drift.whole.confident || third < kLeastThird_s) return drift;
  const double whole_s = drift.whole.seconds;
  const ClockOffset first = OffsetWithin(a, b, options, whole_s, begin, begin + third);
  const ClockOffset last =
      OffsetWithin(a, b, options, whole_s, begin + 2 * third, begin + 3 * third);
  drift.measured = Near(first, whole_s) && Near(last, whole_s);
  drift.first_s = first.seconds, drift.last_s = last.seconds;
  drift.first_at_s = begin + 0.5 * third, drift.last_at_s = begin + 2.5 * third;
  return drift;
}

Signal Resampled(const std::vector<double>& times_s, const std::vector<double>& values,
                 double per_second) {
  Signal signal{times_s.front(), per_second, {}};
  const int count = static_cast<int>((times_s.back() - times_s.front()) * per_second) + 1;
  std::size_t next = 0;
  for (int i = 0; i < count; ++i) {
    const double time = signal.first_s + i / per_second;
    while (next < times_s.size() && times_s[next] <= time) ++next;
    if (next == 0 || next >= times_s.size()) {
      signal.values.push_back(next == 0 ? values.front() : values.back());
      continue;
    }
    const double part = (time - times_s[next - 1]) / (times_s[next] - times_s[next - 1]);
    signal.values.push_back(values[next - 1] + part * (values[next] - values[next - 1]));
  }
  return signal;
}

}  // namespace keypose
