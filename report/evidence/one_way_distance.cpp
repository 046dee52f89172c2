#include "report/evidence/one_way_distance.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/statistics.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/surface_distance.h"

namespace keypose::report {

OneWayDistance DistanceTo(const Mesh& from, const Mesh& to, int samples) {
  const RayScene scene(to.points, to.faces);
  OneWayDistance result;
  result.at_vertex = DistancesTo(scene, from.points);
  Eigen::VectorXd spread = SampledDistances(from, scene, samples, 7);
  result.mean = spread.mean();
  result.rms = std::sqrt(spread.squaredNorm() / static_cast<double>(spread.size()));
  result.max = std::max(spread.maxCoeff(), result.at_vertex.maxCoeff());
  result.p99 = QuantileFloor(std::move(spread), 0.99);
  return result;
}

}  // namespace keypose::report
