#include "core/values/landmark_goal.h"

namespace keypose {

Eigen::Vector3d PositionOf(const SurfacePoint& point, const PointsX3& points) {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) p += point.weights[k] * points.row(point.vertices[k]).transpose();
  return p;
}

}  // namespace keypose
