#include "register/quality/closest_points.h"

#include <cmath>
#include <limits>

#include "core/numbers/parallel.h"

namespace keypose::registration {

namespace {
constexpr std::int64_t kClosestGrain = 256;
constexpr double kRoundingSlack = 1e-6;  // relative; a known bound on a distance is widened by this
}  // namespace

std::vector<RayScene::Foot> ClosestPoints(const RayScene& surface, const PointsX3& points) {
  std::vector<RayScene::Foot> feet(points.rows());
  ParallelBlocks(points.rows(), kClosestGrain, [&](std::int64_t begin, std::int64_t end) {
    double bound = std::numeric_limits<double>::infinity();
    for (std::int64_t i = begin; i < end; ++i) {
      // The distance to a surface changes at most by the distance between two points. So the result
      // of the point before bounds this search.
      if (i > begin)
        bound =
            (std::sqrt(feet[i - 1].squared_distance) + (points.row(i) - points.row(i - 1)).norm()) *
            (1 + kRoundingSlack);
      feet[i] = surface.ClosestPoint(points.row(i), bound);
      if (feet[i].face < 0) feet[i] = surface.ClosestPoint(points.row(i));
    }
  });
  return feet;
}

}  // namespace keypose::registration
