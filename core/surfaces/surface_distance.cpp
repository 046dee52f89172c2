#include "core/surfaces/surface_distance.h"

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"

namespace keypose {

Eigen::VectorXd DistancesTo(const RayScene& surface, const PointsX3& points) {
  constexpr std::int64_t kGrain = 256;
  Eigen::VectorXd distances(points.rows());
  const auto measure = [&](std::int64_t i) {
    const Eigen::Vector3d x = points.row(i).transpose();
    distances[i] = std::sqrt(surface.ClosestPoint(x).squared_distance);
  };
  ParallelFor(points.rows(), measure, kGrain);
  return distances;
}

Eigen::VectorXd SampledDistances(const Mesh& from, const RayScene& to, int samples,
                                 std::uint64_t seed) {
  return DistancesTo(to, SampleSurface(from.points, from.faces, samples, seed).points);
}

}  // namespace keypose
