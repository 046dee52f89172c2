// Ray intersections with a triangle mesh, and closest points on it (with Embree's bounding volume
// hierarchy).
#pragma once

#include <limits>
#include <memory>

#include "core/values/mesh.h"

namespace keypose {

/// An immutable triangle mesh, ready for queries. All queries are const and may run in many threads
/// at once.
class RayScene {
 public:
  struct Hit {
    int face = -1;        ///< -1: nothing hit
    double distance = 0;  ///< along the given `direction`, as a multiple of its length
    double u = 0, v = 0;  ///< hit = (1-u-v) p0 + u p1 + v p2
  };
  struct Foot {
    int face = -1;  ///< -1: nothing within the radius
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
    double squared_distance = std::numeric_limits<double>::infinity();
  };

  /// @throws InputError  no faces, or an index out of range
  RayScene(const PointsX3& points, const FacesX3& faces);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  /// The first hit in [near, far] along the ray. Works in single precision: expect errors of 1e-6
  /// of the scene's size. A ray hits nothing when a coordinate is not finite or beyond 1e18.
  Hit Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double near = 0,
           double far = std::numeric_limits<double>::infinity()) const;
  /// Whether anything lies in [near, far] along the ray.
  bool Occluded(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double near,
                double far) const;
  /// The exact closest point on the surface, in double precision. Of several, that on the face with
  /// the lowest index.
  Foot ClosestPoint(const Eigen::Vector3d& point,
                    double radius = std::numeric_limits<double>::infinity()) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose
