// A ball, and views around it.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "core/pictures/fit_view.h"
#include "core/values/camera.h"
#include "synth/worlds/polygonize.h"

namespace keypose::synth {

using Eigen::Vector3d;

inline constexpr double kRadius = 0.05;

inline Mesh Ball(double radius, double spacing = 0.004) {
  return Polygonize([&](const Vector3d& x) { return x.norm() - radius; },
                    Vector3d::Constant(-1.2 * radius), Vector3d::Constant(1.2 * radius), spacing);
}

// Cameras on a sphere of 0.5 m around the origin.
inline std::vector<View> Around(int count, double elevation_deg, int size = 200) {
  std::vector<View> views;
  for (int k = 0; k < count; ++k) {
    const double a = 2 * M_PI * k / count, e = elevation_deg * M_PI / 180;
    View view;
    view.name = std::to_string(k);
    view.camera.width = view.camera.height = size;
    view.camera.fx = view.camera.fy = 3.0 * size;
    view.camera.cx = view.camera.cy = size / 2.0;
    view.camera_from_world =
        LookAt(0.5 * Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)),
               Vector3d::Zero());
    views.push_back(view);
  }
  return views;
}

}  // namespace keypose::synth
