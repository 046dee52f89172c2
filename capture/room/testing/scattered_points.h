// Points of a ball and of planes, each seen by several views.
#pragma once

#include <Eigen/Core>
#include <random>

#include "capture/testing/test_ring.h"

namespace keypose::capture {

inline Scene SceneWith(const TestRing& ring) {
  Scene scene;
  scene.views = ring.views;
  return scene;
}

inline void Add(Scene& scene, const Eigen::Vector3d& x) {
  SparsePoint point;
  point.position = x;
  point.color.setZero();
  for (int v = 0; v < kRingViews; v += 3) point.views.push_back(v);
  scene.points.push_back(point);
}

inline void AddBall(Scene& scene, int count) {
  std::mt19937 random(2);
  std::normal_distribution<double> gauss(0, 1);
  for (int k = 0; k < count; ++k)
    Add(scene, 0.6 * Eigen::Vector3d(gauss(random), gauss(random), gauss(random)).normalized());
}

}  // namespace keypose::capture
