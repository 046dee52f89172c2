// What a landmark asks of a mesh that is bent: a place of its surface goes to a place in space.
#pragma once

#include <Eigen/Core>
#include <string>

#include "core/mesh.h"

namespace keypose {

/// A point of a mesh as a mix of one to three vertices; unused corners have weight 0.
struct SurfacePoint {
  Eigen::Vector3i vertices = Eigen::Vector3i::Zero();
  Eigen::Vector3d weights{1, 0, 0};
};

/// Where the point is when the vertices are at `points`, V x 3.
Eigen::Vector3d PositionOf(const SurfacePoint& point, const PointsX3& points);

/// One pair of points that belong together.
struct LandmarkGoal {
  std::string name;
  SurfacePoint source;                               ///< on the mesh that is bent
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< where it belongs, in the target's frame
};

}  // namespace keypose
