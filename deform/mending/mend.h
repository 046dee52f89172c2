// Strokes of the brush that mends a mesh, one after the other.
#pragma once

#include <vector>

#include "core/surfaces/mend_stroke.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"

namespace keypose {

/// What a stroke did.
struct MendDone {
  int vertices = 0;     ///< that it moved
  double furthest = 0;  ///< how far one of them, in the mesh's unit
};

struct Mended {
  PointsX3 points;  ///< V x 3
  std::vector<MendDone> done;
};

/// The mesh's vertices after the strokes, in their order; its faces stay. A stroke's places are on
/// `mesh`, and the stroke acts where they have come to by the strokes before it.
/// - smooth: waves shorter than about 1.6 radii fade; fully on the path, less towards the radius
/// - pull: the vertices on the path move by strength x radius along the mean normal there
/// - fill: all vertices nearer than the radius go to a thin plate that the rim holds
/// @throws InputError  a stroke that cannot be done; names it: "stroke 2 (fill)"
/// Cost: 10 ms a stroke of 1,000 vertices. Same bits for any thread count.
Mended Mend(const Mesh& mesh, const std::vector<MendStroke>& strokes, Progress* progress);

}  // namespace keypose
