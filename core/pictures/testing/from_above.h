// A view straight down.
#pragma once

#include "core/pictures/fit_view.h"
#include "core/values/camera.h"

namespace keypose {

inline View FromAbove(int size = 40) {
  View view;
  view.camera.width = view.camera.height = size;
  view.camera.fx = view.camera.fy = size;  // at distance 4 the square covers the middle half
  view.camera.cx = view.camera.cy = size / 2.0;
  view.camera_from_world = LookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0});
  return view;
}

}  // namespace keypose
