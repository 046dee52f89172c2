// Bodies with limbs whose shapes, poses and truth the tests know.
#pragma once

#include <Eigen/Geometry>

#include <cmath>
#include <vector>

#include "core/surfaces/shapes.h"

namespace keypose::registration {

struct Limb {
  Eigen::Vector3d toward;
  double length;
};

/// A ball with limbs: a sphere whose points are moved outwards. `turn` rotates the tessellation,
/// not the shape.
inline Mesh LimbedBody(const std::vector<Limb>& limbs, int levels,
                       const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity()) {
  Mesh mesh = MakeIcosphere(levels);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Eigen::Vector3d direction = (turn * mesh.points.row(v).transpose()).normalized();
    double radius = 0.4;
    for (const Limb& limb : limbs)
      radius += limb.length * std::exp(18 * (direction.dot(limb.toward.normalized()) - 1));
    mesh.points.row(v) = radius * direction.transpose();
  }
  return mesh;
}

/// Left and right are equal, head and tail are not; legs are below.
inline const std::vector<Limb> kQuadruped = {{{0, 1, 0.5}, 0.9},       {{0, -1, 0.2}, 1.2},
                                             {{0.6, 0.6, -0.7}, 0.8},  {{-0.6, 0.6, -0.7}, 0.8},
                                             {{0.6, -0.6, -0.7}, 0.7}, {{-0.6, -0.6, -0.7}, 0.7}};
/// Rotationally symmetric: only a person can say which arm is which.
inline const std::vector<Limb> kStar = {
    {{1, 0, 0}, 0.9}, {{0, 1, 0}, 0.9}, {{-1, 0, 0}, 0.9}, {{0, -1, 0}, 0.9}, {{0, 0, 1}, 0.5}};

/// Bends the spine sideways and down, then rotates and scales the whole.
inline Mesh Posed(const Mesh& mesh) {
  Mesh posed = mesh;
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Eigen::Vector3d p = mesh.points.row(v);
    const Eigen::Matrix3d bend = (Eigen::AngleAxisd(0.5 * p.y(), Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(0.4 * p.y(), Eigen::Vector3d::UnitX()))
                                     .toRotationMatrix();
    posed.points.row(v) = (7 * (turn * (bend * p)) + Eigen::Vector3d(3, 4, 5)).transpose();
  }
  return posed;
}

inline Eigen::Matrix3d OtherTessellation() {
  return Eigen::AngleAxisd(0.37, Eigen::Vector3d(3, 1, 2).normalized()).toRotationMatrix();
}

}  // namespace keypose::registration
