// A bar that is twisted by more than half a turn.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/values/mesh.h"

namespace keypose::interpolation {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kLength = 2;

inline PointsX3 Twisted(const PointsX3& points, double degrees, double from = 0) {
  PointsX3 twisted = points;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double a = std::max(0.0, points(i, 2) - from) / (kLength - from) * degrees * kPi / 180;
    twisted.row(i) << std::cos(a) * points(i, 0) - std::sin(a) * points(i, 1),
        std::sin(a) * points(i, 0) + std::cos(a) * points(i, 1), points(i, 2);
  }
  return twisted;
}

}  // namespace keypose::interpolation
