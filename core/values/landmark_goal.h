// A landmark as a goal of a mesh deformation: a point of the surface should move to a given
// position.
#pragma once

#include <Eigen/Core>
#include <string>

#include "core/values/mesh.h"

namespace keypose {

/// A point of a mesh as a weighted mean of one to three vertices. Unused corners have weight 0.
struct SurfacePoint {
  Eigen::Vector3i vertices = Eigen::Vector3i::Zero();
  Eigen::Vector3d weights{1, 0, 0};
};

/// Where the point is when the vertices are at `points`, V x 3.
Eigen::Vector3d PositionOf(const SurfacePoint& point, const PointsX3& points);

/// One pair of points that belong together.
struct LandmarkGoal {
  std::string name;
  SurfacePoint source;                               ///< on the mesh that is deformed
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< its goal, in the target's frame
};

}  // namespace keypose
