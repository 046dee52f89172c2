// Outlines to pack.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "texture/packing/packing.h"

namespace keypose::texture {

inline UvsX2 Rectangle(double x, double y, double width, double height) {
  UvsX2 p(4, 2);
  p << x, y, x + width, y, x + width, y + height, x, y + height;
  return p;
}

/// A star of triangles around the origin: `tips` bumps of relative height `depth`.
inline Shape Star(int tips, double depth) {
  const int n = 8 * tips;
  Shape shape;
  shape.points = UvsX2::Zero(n + 1, 2);
  shape.corners.resize(n, 3);
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * EIGEN_PI * i / n, r = 1 + depth * std::cos(tips * angle);
    shape.points.row(i) << r * std::cos(angle), r * std::sin(angle);
    shape.corners.row(i) << n, i, (i + 1) % n;
  }
  return shape;
}

inline double OutlineArea(const UvsX2& p) {
  double sum = 0;
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    const Eigen::Index j = (i + 1) % p.rows();
    sum += p(i, 0) * p(j, 1) - p(j, 0) * p(i, 1);
  }
  return sum / 2;
}

}  // namespace keypose::texture
