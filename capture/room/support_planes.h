// Planes that something in the middle of the photographs may stand on.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "capture/room/voxel_grid.h"
#include "core/values/camera.h"

namespace keypose::capture {

/// A plane, and which side is up.
struct Support {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< unit
  double height = 0;                              ///< up . x on the plane

  double Above(const Eigen::Vector3d& x) const { return up.dot(x) - height; }
};

struct SupportOptions {
  double thickness = 0.006;  ///< of the cameras' distance: the plane's points lie within
  double share = 0.05;       ///< least share of the surface around the middle that is plane
  /// A wall, with a relief on it: the median of the sines of the cameras' elevations above the
  /// plane is larger than this, and the plane's up is on average the pictures' up, or any side, by
  /// less than that.
  double steep = 0.6, upright = 0.36;
};

/// Points of a surface, one a voxel, of those that several views show.
struct ThinSurface {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> normals;  ///< unit, outwards
};
ThinSurface SurfaceOf(const VoxelGrid& grid);

/// The plane with most of the surface, of those that the cameras are above and the middle is not
/// below.
/// @param surface  3 points or more
/// @return nothing where none has its share
/// Same bits for any thread count.
std::optional<Support> LargestPlane(const ThinSurface& surface, const std::vector<View>& views,
                                    const Eigen::Vector3d& middle, double distance,
                                    const SupportOptions& options);

/// Planes parallel to `lowest`, where there is more level surface than above and below, from the
/// highest to `lowest` itself.
std::vector<Support> PlanesAbove(const ThinSurface& surface, const Support& lowest,
                                 double thickness);

/// Whether a plane is a wall: cameras that are held upright look at it from the front, from the
/// left and from the right. A table's up is up in the pictures, also seen steeply.
bool IsWall(const Support& plane, const std::vector<View>& views, const Eigen::Vector3d& middle,
            const SupportOptions& options);

}  // namespace keypose::capture
