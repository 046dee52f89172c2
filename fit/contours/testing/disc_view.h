// A sphere, and a mask of it.
#pragma once

#include <cmath>
#include <vector>

#include "core/pictures/fit_view.h"
#include "core/surfaces/face_pairs.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/shapes.h"
#include "core/values/mesh.h"
#include "fit/contours/contours.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

constexpr int kSize = 201;
constexpr double kMiddle = 100;

/// A view whose mask is a disc around the picture's middle.
inline PreparedView DiscView(double radius_px) {
  PreparedView view;
  PreparedView::Level level;
  level.camera = {kSize, kSize, 400, 400, kMiddle, kMiddle};
  level.grey = GreyMask(kSize, kSize, 1);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      *level.grey.at(x, y) = std::hypot(x - kMiddle, y - kMiddle) <= radius_px ? 1 : 0;
  view.levels.push_back(level);
  view.camera_from_world = LookAt({0, -8, 0}, {0, 0, 0});
  return view;
}

/// Radius in pixels of the unit sphere's outline at a distance of 8.
inline double SphereRadius() { return 400 / std::sqrt(8.0 * 8 - 1); }

inline std::vector<ContourPoint> SphereSilhouette(const PreparedView& view) {
  const Mesh sphere = MakeIcosphere(5);
  return FindSilhouette(sphere.points, sphere.faces, FindFacePairs(sphere.faces),
                        RayScene(sphere.points, sphere.faces), view.camera(),
                        view.camera_from_world);
}

}  // namespace keypose::fit
