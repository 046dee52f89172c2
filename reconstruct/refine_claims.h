// What the masks' outlines want of single vertices of a surface, each claim by one view.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "reconstruct/rim_points.h"
#include "reconstruct/silhouettes.h"

namespace keypose::reconstruct {

/// What one view says of one vertex.
struct OutlineClaim {
  int vertex = 0, view = 0;
  double offset = 0;     ///< world units along the vertex normal (area weighted)
  double weight = 0;     ///< in (0, 1]
  double footprint = 0;  ///< world length of a pixel there
};

/// Each kind sorted by vertex and view, one for each of both.
struct OutlineClaims {
  /// In each view the surface's outline is its edges between faces that look at the camera and faces that do not, where nothing of the
  /// surface lies beyond them in the picture. How far such an edge lies from the mask's outline, across it, is a claim on the edge's ends.
  /// Claims that leave the hull of all masks are dropped.
  std::vector<OutlineClaim> folds;
  /// The surface touches each rim point, even where it has fallen in and makes no outline of its own. Not where a fold of that view speaks.
  std::vector<OutlineClaim> rims;
  /// A vertex that projects outside of a mask lies too far out, whatever lies before or behind it, by at least as much as the view that
  /// sees it farthest outside says. Only what is outside by half a pixel and by three times the mean miss of folds: the farthest of many
  /// masks' rims is far by their noise alone.
  std::vector<OutlineClaim> cuts;
};

/// @param rims        of the same masks, or empty
/// @param cut_weight  of a cut, in [0, 1], where folds miss the outlines by 0.15 pixels on average or less; falls with the fourth power of
///                    what they miss more; 0 makes none
/// @param reach_px    claims of more than this are not made
/// Cost: a picture of the mesh, and every vertex once, for each view. Same bits for any thread count.
OutlineClaims FindOutlineClaims(const Mesh& mesh, const PointsX3& normals, const Silhouettes& silhouettes,
                                const std::vector<RimPoint>& rims, double cut_weight, double reach_px);

}  // namespace keypose::reconstruct
