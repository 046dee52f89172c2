// Closest points on the target, and which of them to believe.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/mesh.h"

namespace keypose::registration {

struct Correspondences {
  PointsX3 closest;         ///< V x 3, on the target
  Eigen::VectorXd weights;  ///< V, 0 or 1
};

/// A target, ready for closest point searches.
class TargetSurface {
 public:
  /// @throws InputError  empty, index out of range, or not finite
  explicit TargetSurface(const PointsX3& points, const FacesX3& faces);
  ~TargetSurface();

  /// Exact closest points of the moved source's vertices. A weight is 0 where the vertex normal of the moved source and the target's normal
  /// differ by 90 degrees or more, where the foot lies on the target's boundary, where the vertex has no normal, and, if `reject_crossing`,
  /// where the way to the foot passes through the moved source. Same bits for any thread count.
  /// Source: Amberg et al., CVPR 2007, section 4; Ebner et al., section 4.1.1 (the 90 degrees).
  Correspondences Find(const PointsX3& moved, const FacesX3& source_faces, bool reject_crossing) const;

  /// Distance of each point to the surface.
  Eigen::VectorXd Distances(const PointsX3& points) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose::registration
