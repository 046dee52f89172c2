// Small parts of a mesh that are not joined to the body, as eyeballs, and go where the body goes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh.h"
#include "deform/poisson/poisson.h"
#include "interpolate/maps/face_maps.h"

namespace keypose::interpolation {

/// Keeps each loose part in its place on the body: its centroid's offset from the nearest patch of
/// the body turns with that patch.
///
/// A part rides when its area is below a fifth of the largest part's and it lies on it: the nearest
/// vertex of the body is within 1.5 times the part's own radius of its centroid, in both keys.
/// Parts that constraints touch do not ride. How a part turns and stretches is its own; only its
/// place is set.
class LooseParts {
 public:
  /// @param maps  with body_turn and vertex_turns (where those are empty, offsets turn with the
  /// body)
  LooseParts(const PoissonSystem& system, const PointsX3& v, const PointsX3& u,
             const SegmentMaps& maps);
  /// Moves the riding parts of a frame at time t, in place.
  void Place(double t, PointsX3& frame) const;
  int riding() const { return static_cast<int>(riders_.size()); }

 private:
  struct Rider {
    std::vector<int> own, patch;  ///< vertices
    /// of the patch; offset at the first key, and at the second, turned back
    Eigen::Vector3d turn, start, end;
  };
  Eigen::Vector3d body_turn_;
  std::vector<Rider> riders_;
};

}  // namespace keypose::interpolation
