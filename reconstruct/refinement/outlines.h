// Where the outlines of the masks want a mesh's surface: a displacement for each vertex that some
// view sees on the surface's own outline.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "views/hull/frontier_points.h"
#include "views/hull/silhouettes.h"

namespace keypose::reconstruct {

struct OutlineTargetOptions {
  double reach_px = 10;  ///< outlines farther than this from the surface's own are not believed
  /// constraints within some of these lengths say together what is usual here
  double smoothing_px = 20;
  double violation_weight = 1;  ///< of silhouette violations beside the other terms, where contours
                                ///< meet the outlines exactly
  double errors = 3;  ///< a constraint that misses the usual by more than this many typical
                      ///< deviations has no weight
};

struct SurfaceTargets {
  std::vector<float> offset;  ///< for each vertex, world units along the vertex normal (area
                              ///< weighted): puts the outline on the masks'
  std::vector<float> weight;  ///< how many views say so; a constraint errs by about 0.35 px; 0: no
                              ///< view has the vertex on its outline, offset is 0
  double gap_px = 0;  ///< mean over views and outlines of how far inside of the masks' outlines the
                      ///< surface's lie
  double gap_spread_px = 0;  ///< mean absolute gap
};

/// What occluding contours, frontier points and silhouette violations (outline_constraints.h) ask
/// together. Views whose constraints contradict their surroundings are trusted less, constraints
/// far from what is usual of their kind around them have no weight: a hole in a mask, a bad mask or
/// a bad camera does not pull.
///
/// @param frontier  of the same masks; may be empty
/// @param mesh  triangles, outwards; may be open. Edges without exactly two faces make no outline
/// Constraints are right to first order: after vertices have moved by several pixels, ask again.
/// Cost: a picture of the mesh for each view, and some ten thousand questions of nearest
/// constraints.
/// Same bits for any thread count.
SurfaceTargets OutlineTargets(const Mesh& mesh, const Silhouettes& silhouettes,
                              const std::vector<FrontierPoint>& frontier = {},
                              const OutlineTargetOptions& options = {});

}  // namespace keypose::reconstruct
