// Which photographs a photograph is matched with.
#pragma once

#include <vector>

#include "core/camera.h"
#include "views/hull/depth_bounds.h"
#include "views/prepared/prepared_view.h"

namespace keypose {

/// For each view the best `count` others (fewer when fewer share anything with it), best first.
///
/// Scored by the sum over points that both see of a weight of their triangulation angle: largest at
/// 12 degrees, falling off with 5 degrees below and 15 above, zero outside 3..65; times the square
/// of the resolution ratio when the other is farther away. The points are the sparse ones; where a
/// view has fewer than 100, points of the hull's front that pass a depth test take their place
/// (weakly textured clay), so that rings close whatever the order of the files.
std::vector<std::vector<int>> SelectSourceViews(const std::vector<PreparedView>& views,
                                                const std::vector<DepthBounds>& bounds,
                                                const Scene& scene, int count);

}  // namespace keypose
