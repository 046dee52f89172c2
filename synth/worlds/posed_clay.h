// A clay figure in a pose, ready to be seen: rays, normals, paint under light.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/surfaces/ray_scene.h"
#include "core/values/mesh.h"
#include "synth/worlds/pose.h"
#include "synth/worlds/world.h"

namespace keypose::synth {

/// Light on clay at each vertex of its surface, and where the lamp is.
struct ClayLight {
  const std::vector<float>* lamp = nullptr;            ///< share of the lamp that each vertex sees
  const std::vector<float>* room = nullptr;            ///< share of the room; null: all
  Eigen::Vector3d to_lamp = Eigen::Vector3d::UnitZ();  ///< unit
  double lamp_light = 0.75, room_light = 0.42;         ///< on white clay, linear
  double gloss = 0.035;                                ///< strength of the highlight, linear
};

struct PosedClay {
  PosedClay(const World& the_world, const Pose& pose);
  /// @param points  of the surface where it is; @param smooth  the same without finger-prints
  PosedClay(const World& the_world, const PointsX3& points, const PointsX3& smooth);
  /// Linear RGB that leaves the surface against the ray.
  /// @param direction  of the ray, unit
  Eigen::Vector3d Shade(const RayScene::Hit& hit, const Eigen::Vector3d& direction,
                        const ClayLight& light) const;

  World world;
  Mesh surface;  ///< in the pose; vertices are those of world.rest
  RayScene scene;
  PointsX3 normals;        ///< without the tilt of the finger-prints
  std::vector<int> lumps;  ///< per vertex

 private:
  Eigen::Vector3d PosedSlope(const Eigen::Vector3d& slope, int a, int b, int c) const;
};

}  // namespace keypose::synth
