// Constraints from the masks' outlines on single vertices of a surface, each from one view.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "views/hull/frontier_points.h"
#include "views/hull/silhouettes.h"

namespace keypose::reconstruct {

/// A displacement of one vertex, constrained by one view.
struct OutlineConstraint {
  int vertex = 0, view = 0;
  double offset = 0;     ///< world units along the vertex normal (area weighted)
  double weight = 0;     ///< in (0, 1]
  double footprint = 0;  ///< size of a pixel at the vertex, in world units
};

/// Each kind is sorted by vertex and view, with one constraint for each pair of vertex and view.
struct OutlineConstraints {
  /// Terms of the occluding contour. In each view the surface's outline consists of the edges
  /// between faces towards the camera and faces away from it, where the picture beyond the edge
  /// shows no other part of the surface. The distance of such an edge from the mask's outline,
  /// across it, is a constraint on the edge's ends. Constraints that would leave the hull of all
  /// masks are dropped.
  std::vector<OutlineConstraint> contour;
  /// Each frontier point constrains the nearest surface to touch it, even where the surface is too
  /// deep inside to have an outline of its own. Not where that view has a contour term.
  std::vector<OutlineConstraint> frontier;
  /// Silhouette violations: a vertex that projects outside of a mask is too far out by at least its
  /// largest distance over all views, whatever occludes it. Only vertices outside by at least half
  /// a pixel and three times the mean distance of contours: the largest distance over many masks is
  /// large because of their noise alone.
  std::vector<OutlineConstraint> violations;
};

/// @param frontier          of the same masks, or empty
/// @param violation_weight  weight of a violation, in [0, 1], where contours miss the outlines by
/// 0.15 pixels on average or less; falls with the fourth power of larger distances; 0: no
/// violations
/// @param reach_px          largest displacement of a constraint
/// Cost: one picture of the mesh, and one projection of every vertex, for each view.
/// Same bits for any thread count.
OutlineConstraints FindOutlineConstraints(const Mesh& mesh, const PointsX3& normals,
                                          const Silhouettes& silhouettes,
                                          const std::vector<FrontierPoint>& frontier,
                                          double violation_weight, double reach_px);

}  // namespace keypose::reconstruct
