#include "views/clocks/sound_onsets.h"

#include <algorithm>
#include <cmath>

#include "core/values/size_of.h"

namespace keypose {
namespace {

constexpr int kBefore = 10;         // milliseconds
constexpr double kQuietest = 1e-6;  // of the loudest power: -60 dB
constexpr double kSilence = 1e-9;   // power; below the last bit of 16
constexpr double kPerSecond = 1000;

/// The power that half of all milliseconds exceed.
double UsualPower(std::vector<float> power) {
  const auto middle = power.begin() + static_cast<std::ptrdiff_t>(power.size() / 2);
  std::nth_element(power.begin(), middle, power.end());
  return *middle;
}

/// Weighed 1, 2, 1: a peak of one millisecond has a place between two.
std::vector<double> Smoothed(const std::vector<double>& values) {
  std::vector<double> smooth(values.size());
  for (int i = 0; i < SizeOf(values); ++i) {
    const double before = i > 0 ? values[i - 1] : 0;
    const double after = i + 1 < SizeOf(values) ? values[i + 1] : 0;
    smooth[i] = 0.25 * (before + 2 * values[i] + after);
  }
  return smooth;
}

}  // namespace

Signal SoundOnsets(const SoundPower& power) {
  Signal onsets{power.first_s, kPerSecond, {}};
  if (power.per_milli.empty()) return onsets;
  const double loudest = *std::max_element(power.per_milli.begin(), power.per_milli.end());
  if (loudest < kSilence) return onsets;
  const double noise = std::max(UsualPower(power.per_milli), kQuietest * loudest);
  std::vector<double> rises;
  double sum = 0;
  for (int i = 0; i < SizeOf(power.per_milli); ++i) {
    const int before = std::min(i, kBefore);
    const double mean = before > 0 ? std::max(0.0, sum / before) : power.per_milli[0];
    rises.push_back(std::max(0.0, std::log((power.per_milli[i] + noise) / (mean + noise))));
    sum += power.per_milli[i];
    if (i >= kBefore) sum -= power.per_milli[i - kBefore];
  }
  onsets.values = Smoothed(rises);
  return onsets;
}

}  // namespace keypose
