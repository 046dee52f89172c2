#include "synth/photographs/mishaps.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "core/values/errors.h"

namespace keypose::synth {
namespace {

constexpr double kRadPerDeg = 3.141592653589793 / 180;

/// `count` evenly spaced numbers from 0 to n - 1; the first is `phase` of a gap from the start. A
/// taken number is replaced by the next free one.
std::vector<int> SpreadOut(int count, int n, double phase, const std::vector<int>& taken) {
  std::vector<char> used(static_cast<std::size_t>(n), 0);
  for (const int i : taken) used[i] = 1;
  std::vector<int> chosen;
  for (int k = 0; k < count; ++k) {
    int i = static_cast<int>((k + phase) * n / count) % n;
    while (used[i]) i = (i + 1) % n;
    used[i] = 1;
    chosen.push_back(i);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

/// Parses the number at the beginning of `text` and removes it from `text`.
/// @return false if there is none
bool TakeNumber(std::string_view& text, double* value) {
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), *value);
  if (fault != std::errc() || !std::isfinite(*value)) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

}  // namespace

std::vector<std::string> Mishaps::Problems(int views) const {
  std::vector<std::string> problems;
  if (strays < 0 || hands < 0 || strays + hands > views)
    problems.emplace_back(
        "stray and hand must be >= 0 and together at most the number of photographs");
  if (!(moved_from >= 0 && moved_from <= 1))
    problems.emplace_back("moved: the share of photographs must be in [0, 1]");
  if (!(std::abs(moved_m) <= 0.1))
    problems.emplace_back("moved: the figure may be moved by at most 100 mm");
  if (!(lamp_falls_after >= 0 && lamp_falls_after <= 1))
    problems.emplace_back("lamp-fall must be in [0, 1]");
  return problems;
}

std::uint64_t StraySeed(const Mishaps& mishaps, std::uint64_t world_seed) {
  return mishaps.stray_seed != 0 ? mishaps.stray_seed : world_seed + 1;
}

std::vector<int> StrayViews(const Mishaps& mishaps, int views) {
  return SpreadOut(mishaps.strays, views, 0.4, {});
}

std::vector<int> HandViews(const Mishaps& mishaps, int views) {
  return SpreadOut(mishaps.hands, views, 0.7, StrayViews(mishaps, views));
}

int FirstAfter(double share, int views) { return static_cast<int>(std::lround(share * views)); }

void ReadMove(const std::string& text, Mishaps* mishaps) {
  const auto refuse = [&] {
    return UsageError(
        "synth: '" + text +
        "' does not give a move; write SHARE:MOVE, such as 0.5:5mm,7deg, 0.5:5mm or 0.5:bent");
  };
  std::string_view rest = text;
  if (!TakeNumber(rest, &mishaps->moved_from) || rest.empty() || rest.front() != ':')
    throw refuse();
  rest.remove_prefix(1);
  if (rest.empty() || rest.back() == ',') throw refuse();
  if (rest.find_first_of("0123456789") == std::string_view::npos) {
    mishaps->moved_pose = rest;
    return;
  }
  while (!rest.empty()) {
    double number = 0;
    if (!TakeNumber(rest, &number)) throw refuse();
    const std::string_view unit = rest.substr(0, rest.find(','));
    if (unit == "mm")
      mishaps->moved_m = number / 1000;
    else if (unit == "deg")
      mishaps->moved_rad = number * kRadPerDeg;
    else
      throw refuse();
    rest.remove_prefix(std::min(rest.size(), unit.size() + 1));
  }
}

}  // namespace keypose::synth
