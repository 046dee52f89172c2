// The plane about which a figure is the same on both sides.
#pragma once

#include "core/values/mesh.h"

namespace keypose {

struct MirrorPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  ///< unit
  double offset = 0;                                  ///< normal . x = offset on the plane
  /// Mean distance of the mirrored surface from the surface, over the diagonal, of the 70 % that
  /// fit best: a figure may lift one arm.
  double misfit = 0;
  bool found() const { return misfit <= kMostMisfit; }

  Eigen::Vector3d Mirrored(const Eigen::Vector3d& point) const {
    return point - 2 * (normal.dot(point) - offset) * normal;
  }
  /// Of a direction.
  Eigen::Vector3d Turned(const Eigen::Vector3d& direction) const {
    return direction - 2 * normal.dot(direction) * normal;
  }
  double Distance(const Eigen::Vector3d& point) const { return normal.dot(point) - offset; }

  static constexpr double kMostMisfit = 0.015;
};

/// The upright plane (z up; it may lean by some degrees) that fits best.
/// @throws InputError  no faces
/// Cost: 0.3 s. Same bits for any thread count.
MirrorPlane FindMirrorPlane(const PointsX3& points, const FacesX3& faces);

}  // namespace keypose
