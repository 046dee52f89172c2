// Distances of points, or of samples of one surface, from another surface.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/surfaces/ray_scene.h"
#include "core/values/mesh.h"

namespace keypose {

/// The distance from each point to the closest point of the surface.
/// Same bits for any thread count.
Eigen::VectorXd DistancesTo(const RayScene& surface, const PointsX3& points);

/// The same for samples of a surface, uniform by area (SampleSurface).
/// @param from  must have faces
Eigen::VectorXd SampledDistances(const Mesh& from, const RayScene& to, int samples,
                                 std::uint64_t seed);

}  // namespace keypose
