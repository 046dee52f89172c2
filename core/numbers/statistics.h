// Medians and quantiles, named for how they round: two that differ by one place are two functions.
//
// Values are n numbers in a random-access container (std::vector, std::array, Eigen vector), in any
// order; places are counted from 0 in ascending order. No value may be NaN: which value is returned
// is unspecified then. Of no values, all are 0. Cost: linear on average.
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <type_traits>
#include <utility>

namespace keypose {

template <typename Values>
using ElementOf = std::decay_t<decltype(*std::declval<Values&>().begin())>;

/// The value at a place; places beyond the last mean the last. Reorders the values.
/// @param place  >= 0
template <typename Values>
ElementOf<Values> ValueAtPlace(Values& values, std::ptrdiff_t place) {
  const std::ptrdiff_t n = std::ssize(values);
  if (n == 0) return 0;
  const auto at = values.begin() + std::min(place, n - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The value at place n / 2: of an even number the upper of the two middle ones. Reorders the
/// values.
template <typename Values>
ElementOf<Values> UpperMedianInPlace(Values& values) {
  return ValueAtPlace(values, std::ssize(values) / 2);
}

/// As above, of a copy.
template <typename Values>
ElementOf<Values> UpperMedian(Values values) {
  return UpperMedianInPlace(values);
}

/// The value at place share * (n - 1), rounded down: share 0 gives the least, 1 the greatest.
/// @param share  0..1
template <typename Values>
ElementOf<Values> QuantileFloor(Values values, double share) {
  return ValueAtPlace(
      values, static_cast<std::ptrdiff_t>(share * (static_cast<double>(std::ssize(values)) - 1)));
}

/// The value at place share * (n - 1), rounded to the nearest, halves up.
/// @param share  0..1
template <typename Values>
ElementOf<Values> QuantileNearest(Values values, double share) {
  return ValueAtPlace(values, static_cast<std::ptrdiff_t>(
                                  share * (static_cast<double>(std::ssize(values)) - 1) + 0.5));
}

/// The value at place share * n, rounded down, at most the greatest: up to that share of the values
/// lie below it. With share 0.5 the upper median.
/// @param share  0..1
template <typename Values>
ElementOf<Values> QuantileAbove(Values values, double share) {
  return ValueAtPlace(values,
                      static_cast<std::ptrdiff_t>(share * static_cast<double>(std::ssize(values))));
}

/// The least and the greatest value once share * n values, rounded down, are left out at each end.
/// @param share  0 <= share < 0.5
template <typename Values>
std::pair<ElementOf<Values>, ElementOf<Values>> TrimmedRange(Values values, double share) {
  const std::ptrdiff_t n = std::ssize(values);
  const auto out = static_cast<std::ptrdiff_t>(share * static_cast<double>(n));
  const auto low = ValueAtPlace(values, out);
  return {low, ValueAtPlace(values, n - 1 - out)};
}

}  // namespace keypose
