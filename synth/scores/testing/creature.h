// A figure and balls that scores are taken of.
#pragma once

#include <Eigen/Geometry>

#include "core/values/camera.h"
#include "synth/worlds/polygonize.h"
#include "synth/worlds/world.h"

namespace keypose::synth {

using Eigen::Vector3d;

inline const World& Creature() {
  static const World world = [] {
    WorldOptions options;
    options.spacing_m = 0.006;
    return MakeWorld(options);
  }();
  return world;
}

inline Similarity3 SomeSimilarity() {
  return {3.7,
          Eigen::AngleAxisd(1.1, Vector3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix(),
          {0.4, -2, 1.5}};
}

inline Mesh BallOf(double radius) {
  return Polygonize([&](const Vector3d& x) { return x.norm() - radius; },
                    Vector3d::Constant(-1.2 * radius), Vector3d::Constant(1.2 * radius),
                    radius / 12);
}

}  // namespace keypose::synth
