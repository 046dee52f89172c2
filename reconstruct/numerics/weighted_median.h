// The weighted median.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

namespace keypose::reconstruct {

/// @param values  value and weight; sorted by the call
/// @return the smallest value at which the cumulative weight reaches half of the total; 0 for no
/// values
inline double WeightedMedian(std::vector<std::pair<double, double>>* values) {
  std::sort(values->begin(), values->end());
  double total = 0, sum = 0;
  for (const auto& [value, weight] : *values) total += weight;
  for (const auto& [value, weight] : *values) {
    sum += weight;
    if (2 * sum >= total) return value;
  }
  return 0;
}

}  // namespace keypose::reconstruct
