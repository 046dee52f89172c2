// How good a cloud and a surface are: points in pixel footprints, completeness, surface detail, and
// what stereo adds to the visual hull.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/mesh.h"

namespace keypose::synth {

/// Size of a pixel at a place [m]: its distance from the nearest of the cameras over their focal
/// length.
double PixelFootprint(const std::vector<View>& views, const Eigen::Vector3d& place);

struct PointsScore {
  int points = 0;
  /// share of the points nearer than one pixel's footprint to the true surface
  double within_one_footprint = 0;
  double median = 0, p90 = 0, p99 = 0;  ///< distance to the true surface, in footprints
  double completeness = 0;       ///< share of the true surface that has a point within `reach`
  double completeness_seen = 0;  ///< the same of what at least three cameras see
};

/// @param views  true cameras @param points  in the truth's frame @param reach_m  e.g. 1 % of the
/// height
/// @throws InputError  no points
PointsScore ScorePoints(const Mesh& truth, const std::vector<View>& views, const PointsX3& points,
                        double reach_m);

/// How much of the finger-prints a surface has: its height over the smooth surface, regressed on
/// the true height.
struct DetailScore {
  int places = 0;          ///< vertices within prints of at least a third of the full height
  double gain = 0;         ///< 1: prints as high as they are, 0: none
  double correlation = 0;  ///< in [-1, 1]
};
/// @param truth, smooth  the true surface with prints, and its vertices without them
/// @return no places where the two are equal
DetailScore ScoreDetail(const Mesh& truth, const PointsX3& smooth, const Mesh& mesh);

/// Errors of a surface beside those of the visual hull, at the same places of the true surface.
struct HullComparison {
  double mean_m = 0, hull_mean_m = 0;  ///< distance from the true surface to each
  /// share of places that are more than one footprint farther off than the hull is
  double worse_share = 0;
  double worst_excess_footprints = 0;  ///< 99.9th percentile of how much farther
  double ratio() const { return hull_mean_m > 0 ? mean_m / hull_mean_m : 0; }
};
/// Only places that at least three cameras see: nothing can be known of the others.
HullComparison CompareWithHull(const Mesh& truth, const std::vector<View>& views, const Mesh& mesh,
                               const Mesh& hull);

}  // namespace keypose::synth
