// Displacements of a mesh's vertices from the masks' outlines, for each vertex that is on the
// surface's own outline in some view.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "views/hull/frontier_points.h"
#include "views/hull/silhouettes.h"

namespace keypose::reconstruct {

struct OutlineTargetOptions {
  double reach_px = 10;  ///< outlines farther than this from the surface's own are ignored
  /// distance over which constraints are averaged for a robust local estimate
  double smoothing_px = 20;
  double violation_weight = 1;  ///< of silhouette violations relative to the other terms, where
                                ///< contours match the outlines exactly
  double errors = 3;  ///< a constraint farther than this many standard deviations from the local
                      ///< estimate has no weight
};

struct SurfaceTargets {
  std::vector<float> offset;  ///< per vertex, world units along the vertex normal (area weighted):
                              ///< moves the outline to the masks'
  std::vector<float> weight;  ///< number of supporting views; a constraint has an error of about
                              ///< 0.35 px; 0: the vertex is on no view's outline, and offset is 0
  /// mean distance over views and outlines of the surface's outlines inside of the masks'
  double gap_px = 0;
  double gap_spread_px = 0;  ///< mean absolute gap
};

/// Combines the constraints of occluding contours, frontier points and silhouette violations
/// (outline_constraints.h). The weight of a view decreases when its constraints differ from those
/// around them. Constraints far from the local estimate of their kind are outliers without weight,
/// so that a hole in a mask, a bad mask or a bad camera has no effect.
///
/// @param frontier  of the same masks; may be empty
/// @param mesh  triangles, facing outwards; may be open. Edges without exactly two faces are no
/// outline
/// Constraints are valid to first order: after displacements of several pixels, compute them again.
/// Cost: one picture of the mesh for each view, and some ten thousand nearest-neighbour queries.
/// Same bits for any thread count.
SurfaceTargets OutlineTargets(const Mesh& mesh, const Silhouettes& silhouettes,
                              const std::vector<FrontierPoint>& frontier = {},
                              const OutlineTargetOptions& options = {});

}  // namespace keypose::reconstruct
