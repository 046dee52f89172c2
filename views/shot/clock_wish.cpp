#include "views/shot/clock_wish.h"

#include <cmath>
#include <optional>

#include "core/values/name_list.h"

namespace keypose {
namespace {

constexpr double kMostBegin_s = 1e6;

/// Nothing: not numbers.
std::optional<std::vector<double>> Seconds(const std::string& text) {
  std::vector<double> seconds;
  for (const std::string& word : NamesIn(text)) {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (end != word.c_str() + word.size() || !(std::abs(value) < kMostBegin_s)) return {};
    seconds.push_back(value);
  }
  return seconds;
}

}  // namespace

std::vector<std::string> ClockWishProblems(const std::string& text) {
  if (text == "auto" || text == "off") return {};
  const auto seconds = Seconds(text);
  if (seconds && seconds->size() >= 2) return {};
  return {
      "--clock_offsets is auto, off, or when each film began in seconds, such as 0,1.25,3.4; "
      "not '" +
      text + "'"};
}

ClockWish ParseClockWish(const std::string& text) {
  ClockWish wish;
  if (text == "off") return wish;
  if (text == "auto") {
    wish.how = ClockWish::How::kFound;
    return wish;
  }
  wish.how = ClockWish::How::kGiven;
  wish.begins_s = Seconds(text).value_or(std::vector<double>{});
  return wish;
}

}  // namespace keypose
