// A ball seen from a ring of cameras.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "core/pictures/fit_view.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "views/prepared/prepared_view.h"

namespace keypose {

// Masks of the unit ball from a ring of cameras, so far away that they are nearly orthographic.
inline std::vector<PreparedView> BallRing(int count, double distance = 50, double elevation_deg = 0,
                                          int levels = 2) {
  std::vector<PreparedView> views;
  for (int i = 0; i < count; ++i) {
    const double azimuth = 2 * M_PI * i / count, elevation = elevation_deg * M_PI / 180;
    View view;
    view.name = "v" + std::to_string(i);
    view.camera.width = view.camera.height = 200;
    view.camera.fx = view.camera.fy = 75 * distance;
    view.camera.cx = view.camera.cy = 100;
    view.camera_from_world = LookAt(
        distance * Eigen::Vector3d(std::cos(azimuth) * std::cos(elevation),
                                   std::sin(azimuth) * std::cos(elevation), std::sin(elevation)),
        Eigen::Vector3d::Zero());
    const double radius = view.camera.fx / std::sqrt(distance * distance - 1);
    Image8 mask(200, 200, 1);
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 200; ++x)
        if (std::hypot(x + 0.5 - 100, y + 0.5 - 100) <= radius) *mask.at(x, y) = 255;
    views.push_back(PrepareView(view, i, Image8(200, 200, 3, 128), mask, 1.0, levels));
  }
  return views;
}

}  // namespace keypose
