#include "report/surface_distance.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry.h"
#include "core/parallel.h"
#include "core/ray_scene.h"

namespace keypose::report {
namespace {

Eigen::VectorXd Distances(const PointsX3& points, const RayScene& scene) {
  Eigen::VectorXd result(points.rows());
  ParallelFor(
      points.rows(), [&](std::int64_t i) { result[i] = std::sqrt(scene.ClosestPoint(points.row(i)).squared_distance); }, 256);
  return result;
}

}  // namespace

OneWayDistance DistanceTo(const Mesh& from, const Mesh& to, int samples) {
  const RayScene scene(to.points, to.faces);
  OneWayDistance result;
  result.at_vertex = Distances(from.points, scene);
  Eigen::VectorXd spread = Distances(SampleSurface(from.points, from.faces, samples, 7).points, scene);
  result.mean = spread.mean();
  result.rms = std::sqrt(spread.squaredNorm() / static_cast<double>(spread.size()));
  result.max = std::max(spread.maxCoeff(), result.at_vertex.maxCoeff());
  const auto nth = spread.data() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(spread.size() - 1));
  std::nth_element(spread.data(), nth, spread.data() + spread.size());
  result.p99 = *nth;
  return result;
}

}  // namespace keypose::report
