#include "views/decode/film_turn.h"

#include <cmath>
#include <numbers>

namespace keypose {
namespace {

/// -1, 0 or 1; nothing between.
std::optional<int> Unit(double value) {
  constexpr double kSlack = 0.01;  // programs round the sines of their angles
  for (const int unit : {-1, 0, 1})
    if (std::abs(value - unit) < kSlack) return unit;
  return {};
}

struct Case {
  int a, b, c, d, orientation;
};
constexpr Case kCases[] = {{1, 0, 0, 1, 1}, {-1, 0, 0, 1, 2}, {-1, 0, 0, -1, 3}, {1, 0, 0, -1, 4},
                           {0, 1, 1, 0, 5}, {0, 1, -1, 0, 6}, {0, -1, -1, 0, 7}, {0, -1, 1, 0, 8}};

}  // namespace

std::optional<int> OrientationOf(const DisplayMatrix& matrix) {
  const double scale = std::hypot(matrix[0], matrix[1]), other = std::hypot(matrix[3], matrix[4]);
  if (scale == 0 || other == 0) return {};
  const auto a = Unit(matrix[0] / scale), b = Unit(matrix[1] / scale), c = Unit(matrix[3] / other),
             d = Unit(matrix[4] / other);
  for (const Case& one : kCases)
    if (a == one.a && b == one.b && c == one.c && d == one.d) return one.orientation;
  return {};
}

double TurnOf(const DisplayMatrix& matrix) {
  return std::atan2(matrix[1], matrix[0]) * 180 / std::numbers::pi;
}

}  // namespace keypose
