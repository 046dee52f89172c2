// Closest points on the target, and which of them to use.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::registration {

/// Closest points of V vertices.
struct Correspondences {
  PointsX3 closest;         ///< V x 3, on the target
  Eigen::VectorXd weights;  ///< V, 0 or 1: whether the closest point is used
};

/// Closest points of P points, with the data needed to decide whether to use them.
struct Feet {
  PointsX3 points;         ///< P x 3, on the target
  PointsX3 normals;        ///< P x 3, the target's normals, interpolated, not of unit length
  std::vector<int> faces;  ///< P, -1 for none
  PointsX3 barycentric;    ///< P x 3
  /// P, 0 on the target's boundary or where the normals' cosine is below the limit
  std::vector<char> allowed;
};

/// A target surface with a search structure for closest points.
class TargetSurface {
 public:
  /// @throws InputError  empty, index out of range, or not finite
  explicit TargetSurface(const PointsX3& points, const FacesX3& faces);
  ~TargetSurface();

  /// Exact closest points of the moved source's vertices. A weight is 0 where
  /// - the normals of the moved source and of the target differ by 90 degrees or more,
  /// - the closest point is on the target's boundary,
  /// - the vertex has no normal.
  /// Same bits for any thread count.
  /// Source: Amberg et al., CVPR 2007, section 4; Ebner et al., section 4.1.1 (the 90 degrees).
  Correspondences Find(const PointsX3& moved, const FacesX3& source_faces) const;

  /// Closest points of points with unit normals. A closest point is allowed where the cosine
  /// between the two normals is at least `min_cosine` and it is not on the target's boundary.
  /// @param near  points on the target that may be close, such as those of the last search; they
  ///              only save time
  Feet FindFeet(const PointsX3& points, const PointsX3& normals, double min_cosine,
                const PointsX3* near = nullptr) const;

  /// Distance of each point to the surface.
  Eigen::VectorXd Distances(const PointsX3& points) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose::registration
