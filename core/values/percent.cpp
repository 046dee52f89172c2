#include "core/values/percent.h"

#include <fmt/format.h>

#include <cmath>

namespace keypose {

std::string PercentHalfUp(double share) {
  return std::to_string(static_cast<int>(std::lround(100 * share))) + " %";
}

std::string PercentHalfEven(double share) { return fmt::format("{:.0f} %", 100 * share); }

}  // namespace keypose
