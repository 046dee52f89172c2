// Scores of a point cloud and a surface: distances in pixel footprints, completeness, surface
// detail, and the gain of stereo over the visual hull.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/mesh.h"

namespace keypose::synth {

/// Size of a pixel at a place [m]: distance to the nearest camera / focal length [px].
double PixelFootprint(const std::vector<View>& views, const Eigen::Vector3d& place);

struct PointsScore {
  int points = 0;
  /// share of points closer to the true surface than one footprint
  double within_one_footprint = 0;
  double median = 0, p90 = 0, p99 = 0;  ///< distance to the true surface, in footprints
  double completeness = 0;              ///< share of the true surface with a point within `reach_m`
  double completeness_seen = 0;         ///< the same for the part that at least three cameras see
};

/// @param views  true cameras @param points  in the truth's frame @param reach_m  e.g. 1 % of the
/// height
/// @throws InputError  no points
PointsScore ScorePoints(const Mesh& truth, const std::vector<View>& views, const PointsX3& points,
                        double reach_m);

/// How well a surface reproduces the finger-prints: regression of its height over the smooth
/// surface on the true height.
struct DetailScore {
  int places = 0;          ///< vertices in prints of at least a third of the full height
  double gain = 0;         ///< 1: prints of true height, 0: no prints
  double correlation = 0;  ///< in [-1, 1]
};
/// @param truth, smooth  the true surface with prints, and its vertices without them
/// @return `places` excludes vertices at which the two are equal
DetailScore ScoreDetail(const Mesh& truth, const PointsX3& smooth, const Mesh& mesh);

/// Errors of a surface and of the visual hull at the same places of the true surface.
struct HullComparison {
  double mean_m = 0, hull_mean_m = 0;  ///< distance from the true surface to each
  /// share of places where the error exceeds the hull's by more than one footprint
  double worse_share = 0;
  double worst_excess_footprints = 0;  ///< 99.9th percentile of that excess
  double ratio() const { return hull_mean_m > 0 ? mean_m / hull_mean_m : 0; }
};
/// Only at places that at least three cameras see; reconstruction cannot measure the others.
HullComparison CompareWithHull(const Mesh& truth, const std::vector<View>& views, const Mesh& mesh,
                               const Mesh& hull);

}  // namespace keypose::synth
