// A camera, and points around its axis.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <vector>

#include "core/pictures/fit_view.h"
#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "views/placement/surface_features.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

inline const Pinhole kCamera{800, 800, 1000, 1000, 400, 400};

inline std::vector<Rigid3> Ring(int count) {
  std::vector<Rigid3> poses;
  for (int i = 0; i < count; ++i) {
    const double a = 2 * M_PI * i / count;
    poses.push_back(LookAt({6 * std::cos(a), 6 * std::sin(a), 2}, {0, 0, 0}));
  }
  return poses;
}

/// Matches of a plane of places, of which every fifth shows another place.
inline std::vector<FeatureMatch> PlaneMatches(const PointsX3& points, const Rigid3& pose) {
  std::vector<FeatureMatch> matches;
  std::mt19937 random(7);
  for (int i = 0; i < points.rows(); ++i) {
    FeatureMatch match;
    match.point.vertices = {i, i, i};
    match.pixel = kCamera.Project(pose * points.row(i).transpose());
    if (i % 5 == 0) match.pixel = Eigen::Vector2d(random() % 800, random() % 800);
    matches.push_back(match);
  }
  return matches;
}

inline PointsX3 Patch() {
  PointsX3 points(400, 3);
  for (int i = 0; i < 400; ++i) {
    const double x = (i % 20) / 10.0 - 1, y = static_cast<double>(i / 20) / 10 - 1;
    points.row(i) << x, y, 0.3 * std::sin(2 * x) * std::cos(2 * y);
  }
  return points;
}

}  // namespace keypose::fit
