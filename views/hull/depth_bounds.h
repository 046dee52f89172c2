// Bounds of a pixel's depth: the part of its ray inside the visual hull.
#pragma once

#include "views/hull/visual_hull.h"
#include "views/prepared/prepared_view.h"

namespace keypose {

/// Inverse depths between which the surface lies; nearest = 0 where the ray misses the hull.
struct DepthBounds {
  int shift = 0;  ///< entry (x, y) covers level-0 pixels (x << shift, y << shift) onwards
  ImageF nearest, farthest;  ///< 1 channel; inverse depth of the hull's entry and exit with a
                             ///< margin, nearest >= farthest
  ImageF slope;  ///< 2 channels: gradient of the entry's inverse depth per entry of this grid,
                 ///< smoothed; an initial estimate of the tilt
};

/// Casts one ray per pixel of the view's coarsest level. Bounds are widened over a 3 x 3 window and
/// by 1.5 voxels.
DepthBounds HullDepthBounds(const VisualHull& hull, const PreparedView& view);

}  // namespace keypose
