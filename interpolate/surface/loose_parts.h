// Small parts of a mesh that are not connected to the body, such as eyeballs, and move with it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/size_of.h"
#include "deform/poisson/poisson.h"
#include "interpolate/maps/face_maps.h"

namespace keypose::interpolation {

/// Keeps each loose part in its place on the body: the offset of its centroid from the nearest
/// patch of the body turns with that patch.
///
/// A part is moved when its area is below a fifth of the largest part's and when it lies on that
/// part: in both keys the nearest vertex of the body is within 1.5 times the part's own radius of
/// its centroid. Parts with constraints are not moved. Only a part's place is set, not its turn and
/// stretch.
class LooseParts {
 public:
  /// @param maps  with body_turn and vertex_turns (where those are empty, offsets turn with the
  /// body)
  LooseParts(const PoissonSystem& system, const PointsX3& v, const PointsX3& u,
             const SegmentMaps& maps);
  /// Moves the loose parts of a frame at time t, in place.
  void Place(double t, PointsX3& frame) const;
  int riding() const { return SizeOf(riders_); }

 private:
  struct Rider {
    std::vector<int> own, patch;  ///< vertices
    /// turn of the patch; the offset at the first key, and at the second, turned back
    Eigen::Vector3d turn, start, end;
  };
  Eigen::Vector3d body_turn_;
  std::vector<Rider> riders_;
};

}  // namespace keypose::interpolation
