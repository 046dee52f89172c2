// Cameras over a plane.
#pragma once

#include <cmath>
#include <string>

#include "core/values/camera.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct {

using Eigen::Vector2d, Eigen::Vector3d;

inline Camera Lens() {
  Camera camera;
  camera.width = 480, camera.height = 360;
  camera.fx = camera.fy = 700, camera.cx = 240, camera.cy = 180;
  return camera;
}

/// Of one tripod, so far from the mat, when the mat is turned.
inline View From(double distance, double above, double turn, const std::string& name) {
  return testing::LookFrom(distance * Vector3d(std::cos(turn) * std::cos(above),
                                               std::sin(turn) * std::cos(above), std::sin(above)),
                           Lens(), name);
}

}  // namespace keypose::reconstruct
