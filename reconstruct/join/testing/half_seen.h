// One half of a figure, as points.
#pragma once

#include <gmock/gmock.h>

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct {

/// Points on an asymmetric coloured body: three balls of different sizes, of which the side in
/// direction `skip` is unseen.
inline Scene HalfSeen(const Eigen::Vector3d& skip, const Similarity3& frame, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  const std::vector<std::pair<Eigen::Vector3d, double>> balls = {
      {{0, 0, 0}, 0.05}, {{0.02, 0.01, 0.07}, 0.03}, {{0.06, -0.01, 0.01}, 0.02}};
  Scene scene;
  while (scene.points.size() < 3000) {
    const std::size_t b = random() % balls.size();
    // one after the other: compilers disagree on the order of a call's arguments
    const double z = normal(random), y = normal(random), x = normal(random);
    const Eigen::Vector3d normal_out = Eigen::Vector3d(x, y, z).normalized();
    if (normal_out.dot(skip) > 0.3) continue;
    SparsePoint point =
        testing::PointAt(frame * Eigen::Vector3d(balls[b].first + balls[b].second * normal_out +
                                                 1e-4 * Eigen::Vector3d::Constant(normal(random))));
    point.color << static_cast<std::uint8_t>(b == 0 ? 200 : 60),
        static_cast<std::uint8_t>(b == 1 ? 200 : 60), static_cast<std::uint8_t>(b == 2 ? 200 : 60);
    scene.points.push_back(point);
  }
  return scene;
}

}  // namespace keypose::reconstruct
