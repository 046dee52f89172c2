// What the masks' outlines want of single vertices of a surface, each constraint by one view.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "views/hull/frontier_points.h"
#include "views/hull/silhouettes.h"

namespace keypose::reconstruct {

/// What one view asks of one vertex.
struct OutlineConstraint {
  int vertex = 0, view = 0;
  double offset = 0;     ///< world units along the vertex normal (area weighted)
  double weight = 0;     ///< in (0, 1]
  double footprint = 0;  ///< world length of a pixel there
};

/// Each kind sorted by vertex and view, one for each of both.
struct OutlineConstraints {
  /// Terms of the occluding contour: in each view the surface's outline is its edges between faces
  /// that look at the camera and faces that do not, where nothing of the surface lies beyond them
  /// in the picture. How far such an edge lies from the mask's outline, across it, is a constraint
  /// on the edge's ends. Constraints that leave the hull of all masks are dropped.
  std::vector<OutlineConstraint> contour;
  /// The surface touches each frontier point, even where it has fallen in and makes no outline of
  /// its own. Not where that view has a contour term.
  std::vector<OutlineConstraint> frontier;
  /// Silhouette violations: a vertex that projects outside of a mask lies too far out, whatever
  /// lies before or behind it, by at least as much as the view that sees it farthest outside says.
  /// Only what is outside by half a pixel and by three times the mean miss of contours: the
  /// farthest of many masks' outlines is far by their noise alone.
  std::vector<OutlineConstraint> violations;
};

/// @param frontier  of the same masks, or empty
/// @param violation_weight  of a violation, in [0, 1], where contours miss the outlines by 0.15
/// pixels
///   on average or less; falls with the fourth power of what they miss more; 0 makes none
/// @param reach_px  constraints of more than this are not made
/// Cost: a picture of the mesh, and every vertex once, for each view.
/// Same bits for any thread count.
OutlineConstraints FindOutlineConstraints(const Mesh& mesh, const PointsX3& normals,
                                          const Silhouettes& silhouettes,
                                          const std::vector<FrontierPoint>& frontier,
                                          double violation_weight, double reach_px);

}  // namespace keypose::reconstruct
