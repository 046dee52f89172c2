// Triangle meshes of even size of a clay solid in a pose, each with different vertices, like two
// scans of one object.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/surfaces/ray_scene.h"
#include "core/values/mesh.h"
#include "synth/worlds/clay.h"
#include "synth/worlds/pose.h"

namespace keypose::synth {

/// The surface of a solid in a pose, dense enough for distance measurements. Gives the material
/// point of every surface point.
class PosedSurface {
 public:
  /// @param spacing  of the dense mesh [m]; a quarter of the final meshes' edge length is
  /// sufficient
  /// @throws InputError  no solid, or it is smaller than the spacing
  PosedSurface(const Clay& clay, const Pose& pose, double spacing);

  /// Signed distance [m] to the dense mesh, negative inside.
  double Distance(const Eigen::Vector3d& posed) const;
  /// The material point (rest pose, exactly on the solid) whose posed position is closest to
  /// `posed`, to the accuracy of the dense mesh.
  Eigen::Vector3d MaterialAt(const Eigen::Vector3d& posed) const;
  /// Closest point of the dense mesh.
  Eigen::Vector3d Closest(const Eigen::Vector3d& posed) const {
    return scene_.ClosestPoint(posed).point;
  }

  const PointsX3& points() const { return points_; }
  const Clay& clay() const { return clay_; }
  const Pose& pose() const { return pose_; }
  double area() const { return area_; }

 private:
  Clay clay_;
  Pose pose_;
  Mesh rest_;
  PointsX3 points_;   // of rest_, posed
  PointsX3 normals_;  // of faces, posed
  RayScene scene_;
  double area_ = 0;
};

/// A mesh of the posed surface and the material point of each vertex.
struct Tessellation {
  Mesh mesh;          ///< its points are exactly `material` mapped by the pose
  PointsX3 material;  ///< in the rest pose, exactly on the solid
};

/// A closed mesh of about `vertices` vertices with even spacing. `seed` rotates and shifts its
/// lattice.
///
/// @throws InputError  fewer than 50 vertices, or so few that the lattice misses the solid. Same
/// bits for any thread count. Delaunay edge flips and moving vertices to the middle of their
/// neighbours even out the triangles.
Tessellation Tessellate(const PosedSurface& surface, int vertices, std::uint64_t seed);

}  // namespace keypose::synth
