// Exact closest points of many points that lie in the order of a surface.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "core/ray_scene.h"

namespace keypose::registration {

/// One foot a point, no face where there is none. Faster where each point is near the one before.
/// Same bits for any thread count.
std::vector<RayScene::Foot> ClosestPoints(const RayScene& surface, const PointsX3& points);

}  // namespace keypose::registration
