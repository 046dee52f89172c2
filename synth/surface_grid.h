// Evenly sized triangle meshes of a clay solid in a pose, each with its own vertices: what two
// scans of one thing look like.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/mesh.h"
#include "core/ray_scene.h"
#include "synth/clay.h"
#include "synth/pose.h"

namespace keypose::synth {

/// The surface of a solid in a pose, dense enough to measure distances to; every point of it knows
/// its material point.
class PosedSurface {
 public:
  /// @param spacing  of the dense mesh [m]; a quarter of the wanted meshes' edge is fine
  /// @throws InputError  no solid, or smaller than the spacing
  PosedSurface(const Clay& clay, const Pose& pose, double spacing);

  /// Signed distance [m] to the dense mesh, negative inside.
  double Distance(const Eigen::Vector3d& posed) const;
  /// The material point of the rest pose, exactly on the solid, whose place is closest to `posed`,
  /// to the dense mesh's accuracy.
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
  Mesh mesh;          ///< points exactly where the pose takes `material`
  PointsX3 material;  ///< in the rest pose, exactly on the solid
};

/// A closed mesh of about `vertices` vertices, evenly sized, whose lattice is turned and shifted by
/// `seed`.
///
/// @throws InputError  fewer than 50 vertices, or so few that the lattice misses the solid
/// Same bits for any thread count. Triangles are evened by edge flips (Delaunay) and by moving
/// vertices to the middle of their neighbours.
Tessellation Tessellate(const PosedSurface& surface, int vertices, std::uint64_t seed);

}  // namespace keypose::synth
