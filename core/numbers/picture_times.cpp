#include "core/numbers/picture_times.h"

#include <algorithm>
#include <cmath>

namespace keypose {
namespace {

constexpr double kJitter = 0.25;        // frames; containers round times, cameras wait for light
constexpr double kSameRate = 1e-3;      // relative
constexpr double kRounding_s = 1.5e-3;  // Matroska has times in milliseconds

double MedianStep(const std::vector<double>& times) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  const auto middle = steps.begin() + std::ssize(steps) / 2;
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

bool Fits(const std::vector<double>& times, double rate) {
  double low = 0, high = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double off = (times[i] - times[0]) * rate - static_cast<double>(i);
    low = std::min(low, off);
    high = std::max(high, off);
  }
  return high - low <= 2 * kJitter;
}

/// The rate between pictures of which none is missing: the header's or a usual one where they are
/// near it.
double RateWithoutGaps(const std::vector<double>& times, double header) {
  const double median = 1 / MedianStep(times), whole = std::round(median);
  for (const double rate : {header, whole, whole * 1000 / 1001})
    if (rate > 0 && std::abs(median / rate - 1) < kSameRate + kRounding_s * median) return rate;
  return median;
}

}  // namespace

PictureRate RateOf(const std::vector<double>& times, double header) {
  if (times.size() < 2) return {header, true};
  const double span = times.back() - times.front();
  if (!(span > 0)) return {header, true};
  const double mean = static_cast<double>(times.size() - 1) / span;
  const bool confirmed = header > 0 && std::abs(mean / header - 1) < kSameRate + kRounding_s / span;
  if (confirmed && Fits(times, header)) return {header, true};
  if (Fits(times, mean)) return {mean, true};
  return {RateWithoutGaps(times, header), false};
}

std::vector<int> FrameNumbers(const std::vector<double>& times, const PictureRate& rate) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double after = (times[i] - times.front()) * rate.per_second;
    const int number = rate.constant ? static_cast<int>(i) : static_cast<int>(std::lround(after));
    numbers.push_back(i == 0 ? 0 : std::max(number, numbers.back() + 1));
  }
  return numbers;
}

}  // namespace keypose
