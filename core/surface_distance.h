// How far points, or points spread over one surface, lie from another surface.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/mesh.h"
#include "core/ray_scene.h"

namespace keypose {

/// From each point to the closest point of the surface.
/// Same bits for any thread count.
Eigen::VectorXd DistancesTo(const RayScene& surface, const PointsX3& points);

/// The same from points spread over a surface, uniformly by area (SampleSurface).
/// @param from  with faces
Eigen::VectorXd SampledDistances(const Mesh& from, const RayScene& to, int samples,
                                 std::uint64_t seed);

}  // namespace keypose
