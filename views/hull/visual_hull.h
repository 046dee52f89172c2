// The visual hull: the space that no mask rules out, on a voxel grid. It bounds depths before
// stereo and fills places that stereo does not reconstruct.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/values/mesh.h"
#include "views/prepared/prepared_view.h"

namespace keypose {

/// Number of views that must see a point outside of their masks for it to be outside. The more
/// views there are, the more likely some masks cut off parts of the figure.
inline int OutsideVotes(std::size_t views) {
  return std::clamp(static_cast<int>(views / 14), 1, 5);
}

struct VisualHullOptions {
  int resolution = 160;  ///< voxels along the longest side, in [8, 512]
  /// a voxel is carved when at least this many views see it outside of their masks
  int outside_votes = 2;
  double mask_margin_px = 2;  ///< masks are grown by this at level 0, to allow for their errors
};

class VisualHull {
 public:
  /// Depths along a ray, in units of its direction, between which the hull lies.
  struct Interval {
    double front = 0, back = 0;
  };
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< lower corner of voxel (0,0,0)
  double cell = 0;                                   ///< side of a voxel
  Eigen::Vector3i size = Eigen::Vector3i::Zero();
  std::vector<std::uint8_t> inside;  ///< size x * y * z, x fastest

  bool Inside(int x, int y, int z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < size.x() && y < size.y() && z < size.z() &&
           inside[(static_cast<std::size_t>(z) * size.y() + y) * size.x() + x];
  }
  bool Contains(const Eigen::Vector3d& x) const;
  /// First entry into and last exit from the hull; nothing when the ray misses it.
  std::optional<Interval> March(const Eigen::Vector3d& from,
                                const Eigen::Vector3d& direction) const;
  double Volume() const;
};

/// Carves by all views' masks. The grid fits the hull with a margin of two voxels.
///
/// A view does not count for points outside of its picture. A point that fewer than two views see
/// is outside.
/// @throws InputError  fewer than 2 views with a mask, or the masks have no common space; names the
/// cause
/// Cost: whole octree cells are tested against distance transforms of the masks, so only cells at
/// the surface are divided. Departs from Szeliski (CVGIP 1993): several views must agree, so that
/// one bad mask does not cut the figure.
VisualHull CarveVisualHull(const std::vector<PreparedView>& views,
                           const VisualHullOptions& options);

/// Points at the centres of the hull's surface voxels with outward normals.
PointCloud HullSurface(const VisualHull& hull);

}  // namespace keypose
