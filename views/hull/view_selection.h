// Selects the photographs that each photograph is matched with.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "views/hull/depth_bounds.h"
#include "views/prepared/prepared_view.h"

namespace keypose {

/// For each view the best `count` others (fewer when fewer share points with it), best first.
///
/// The score is a sum over points that both views see. Each point's weight depends on its
/// triangulation angle: largest at 12 degrees, falling off with 5 degrees below and 15 above, zero
/// outside 3..65. If the other view is farther away, the weight is multiplied by the square of the
/// resolution ratio. The points are the sparse ones. Where a view has fewer than 100 (weakly
/// textured clay), points of the hull's front that pass a depth test replace them, so that rings
/// close in any order of the files.
std::vector<std::vector<int>> SelectSourceViews(const std::vector<PreparedView>& views,
                                                const std::vector<DepthBounds>& bounds,
                                                const Scene& scene, int count);

}  // namespace keypose
