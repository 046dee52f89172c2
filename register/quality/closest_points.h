// Exact closest points on a surface for many points.
#pragma once

#include <vector>

#include "core/surfaces/ray_scene.h"
#include "core/values/mesh.h"

namespace keypose::registration {

/// The closest point on the surface for each point; face -1 where there is none. Faster when each
/// point is near the one before it.
/// Same bits for any thread count.
std::vector<RayScene::Foot> ClosestPoints(const RayScene& surface, const PointsX3& points);

}  // namespace keypose::registration
