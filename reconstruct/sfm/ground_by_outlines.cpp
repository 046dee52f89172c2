#include "reconstruct/sfm/ground_by_outlines.h"

#include <vector>

#include "core/io/pictures/sight_io.h"
#include "core/numbers/statistics.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {
namespace {

// Measured on 27 synthetic sets (docs/decisions/ground-by-outlines.md). Sensitivity:
// docs/results/sensitivity.md.
struct OutlineGroundTuning {
  KEYPOSE_TUNED(double, kOutliers, 0.01);  // of the points, at each end
  KEYPOSE_TUNED(double, kSpread, 0.02);  // of the height; at most 0.005 for sets with right cameras
};

Eigen::Vector3d QuantilesOf(const Scene& scene, double share) {
  Eigen::Vector3d result;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const SparsePoint& point : scene.points) values.push_back(point.position[k]);
    result[k] = QuantileFloor(std::move(values), share);
  }
  return result;
}

}  // namespace

std::optional<GroundContact> GroundOf(const ImageSet& set, const Scene& level) {
  if (level.points.empty()) return std::nullopt;
  const Sight sight = ReadMaskedViews(set, level);
  const Eigen::Vector3d low = QuantilesOf(level, OutlineGroundTuning::kOutliers),
                        high = QuantilesOf(level, 1 - OutlineGroundTuning::kOutliers);
  const auto ground = FindGroundContact(sight.views, sight.masks, low, high);
  if (!ground || ground->spread > OutlineGroundTuning::kSpread * (high.z() - low.z()))
    return std::nullopt;
  return ground;
}

}  // namespace keypose::reconstruct
