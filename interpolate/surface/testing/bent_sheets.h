// Surfaces that bend, and pairs of keys.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::interpolation {

inline constexpr double kPi = std::numbers::pi;

inline double Diagonal(const PointsX3& p) { return BoundingDiagonal(p); }
inline double Gap(const PointsX3& a, const PointsX3& b) {
  return (a - b).rowwise().norm().maxCoeff() / Diagonal(b);
}

/// A tube along z from 0 to `length`, bent through `angle` in the xz plane and squashed across.
inline PointsX3 Bent(const PointsX3& points, double length, double angle, double squash = 1) {
  PointsX3 bent = points;
  const double radius = length / angle;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double a = points(i, 2) / radius, r = radius - squash * points(i, 0);
    bent.row(i) << radius - r * std::cos(a), points(i, 1) / squash, r * std::sin(a);
  }
  return bent;
}

struct Keys {
  Mesh mesh = MakeCylinder(0.12, 2, 16, 40);
  PointsX3 u = Bent(mesh.points, 2, 150 * kPi / 180, 1.2);
};

}  // namespace keypose::interpolation
