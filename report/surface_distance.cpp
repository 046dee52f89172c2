#include "report/surface_distance.h"

#include <algorithm>
#include <cmath>

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
  const auto nth =
      spread.data() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(spread.size() - 1));
  std::nth_element(spread.data(), nth, spread.data() + spread.size());
  result.p99 = *nth;
  return result;
}

}  // namespace keypose::report
