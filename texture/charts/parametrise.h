// Flattens a chart with as little change of each triangle's shape and size as possible.
#pragma once

#include <optional>

#include "texture/charts/charts.h"

namespace keypose::texture {

/// @param chart       a disk
/// @param iterations  local-global rounds, >= 1
/// @return one position per local vertex [units of the points], scaled so that the areas agree;
/// nothing when a triangle flips or nearly collapses, or the boundary crosses itself (then cut the
/// chart)
/// Source: Liu, Zhang, Xu, Gotsman, Gortler, SGP 2008 (as rigid as possible). It starts from a
/// projection to the mean plane if that flips nothing, else from Tutte's embedding with the
/// boundary on a circle.
/// Departs: cotangents are kept in [1e-2, 1e2].
std::optional<UvsX2> Flattened(const Surface& surface, const Chart& chart, int iterations);

/// Whether the boundary does not cross itself (in floating point; FindAtlasFaults tests a whole
/// layout exactly).
bool RimIsSimple(const Chart& chart, const UvsX2& uvs);

/// Area-weighted mean, 99th percentile and maximum of max(s1, 1 / s2) over the faces, where s1 >=
/// s2 are the stretches from the surface to the plane. 1 is an isometry.
struct Distortion {
  double mean = 1, p99 = 1, max = 1;
};
/// Larger over smaller stretch of a face, by its index in the chart.
double ConformalRatio(const Surface& surface, const Chart& chart, const UvsX2& uvs, int face);
Distortion MeasureDistortion(const Surface& surface, const Chart& chart, const UvsX2& uvs);

/// Singular values s1 >= s2 >= 0 of the map from triangle abc in space to pqr in the plane;
/// infinite where abc has no area.
Eigen::Vector2d Stretches(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                          const Eigen::Vector3d& c, const Eigen::Vector2d& p,
                          const Eigen::Vector2d& q, const Eigen::Vector2d& r);

}  // namespace keypose::texture
