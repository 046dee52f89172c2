// Pictures of a turn as columns.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "core/surfaces/shapes.h"
#include "export/gltf/weighted_shapes.h"

namespace keypose::exporting {

/// A rigid turn about z by `degrees` in all.
inline std::vector<PointsX3> Turning(int count, double degrees) {
  const PointsX3 rest = MakeBox(1, 2, 3).points;
  std::vector<PointsX3> points(count, rest);
  for (int i = 0; i < count; ++i) {
    const double angle = degrees * std::numbers::pi / 180 * i / (count - 1);
    points[i].col(0) = std::cos(angle) * rest.col(0) - std::sin(angle) * rest.col(1);
    points[i].col(1) = std::sin(angle) * rest.col(0) + std::cos(angle) * rest.col(1);
  }
  return points;
}

inline Pictures PicturesOf(const std::vector<PointsX3>& points) {
  Pictures pictures;
  for (const PointsX3& one : points) pictures.push_back(&one);
  return pictures;
}

}  // namespace keypose::exporting
