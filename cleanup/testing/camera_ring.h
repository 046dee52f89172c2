// Cameras around a figure.
#pragma once

#include <vector>

#include "core/surfaces/shapes.h"
#include "core/testing/shots.h"
#include "core/values/camera.h"

namespace keypose::cleanup {

/// `count` of twelve cameras in a ring.
inline std::vector<View> Ring(const Eigen::Vector3d& middle, double elevation_deg, int count) {
  std::vector<View> views = MasksFromRings(MakeBox(1, 1, 1), middle, {elevation_deg}, 12, 64).views;
  views.resize(static_cast<std::size_t>(count));
  return views;
}

}  // namespace keypose::cleanup
