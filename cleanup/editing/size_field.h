// Wanted edge lengths over a surface, so that a given number of faces represents the shape best.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/tuned.h"

namespace keypose::cleanup {

/// kExponent and kGrowth: tuned on the plush dog
/// (docs/algorithms/cleanup.md). The others: no record of the data;
/// those of limbs are for eight faces around a rod.
struct EdgeSizeTuning {
  KEYPOSE_TUNED(double, kExponent, 1.0 / 3);  ///< sizes are proportional to curvature^-kExponent
  KEYPOSE_TUNED(double, kGrowth, 0.6);  ///< largest change of size per length along the surface
  /// smallest size in curved places, of the edge length of equal triangles
  KEYPOSE_TUNED(double, kSmallest, 0.3);
  KEYPOSE_TUNED(double, kLargest, 2);  ///< largest size in flat places, likewise
  /// smallest size on limbs that are thinner than the triangles, likewise
  KEYPOSE_TUNED(double, kLimbSmallest, 0.15);
  /// size on limbs, of the thickness; the chord of an eighth of a circle is 0.38 of the diameter
  KEYPOSE_TUNED(double, kLimbShare, 0.36);
  /// curvature times half the thickness from which on a place is a limb: 1 on a rod, 0 on a sheet
  KEYPOSE_TUNED(double, kRound, 0.4);
};

struct SizeRules {
  int faces = 20000;                            ///< number of faces that the sizes should give
  bool follow_curvature = true;                 ///< false: equal sizes, except on thin limbs
  double exponent = EdgeSizeTuning::kExponent;  ///< see there
  double growth = EdgeSizeTuning::kGrowth;
};

/// The larger absolute principal curvature at each vertex, measured over about one edge length.
///
/// @return V x [1/units]
/// Source: Rusinkiewicz, 3DPVT 2004 (differences of normals over faces).
/// Departs: no local frames; root mean square over the fan.
Eigen::VectorXd MaxCurvature(const Mesh& surface);

/// Thickness of the body at each vertex: the distance along the inward normal to the other side;
/// infinite when there is none.
/// @return V x [units]
Eigen::VectorXd Thickness(const Mesh& surface);

/// Wanted edge length at each vertex of a closed surface: proportional to curvature^-exponent,
/// within limits, and scaled to give the wanted number of faces. Exponent 1/3 minimises the mean
/// squared distance of the triangles from the surface; with 1/2 all triangles have the same
/// distance. Round limbs get at least eight faces around them: no edge is longer than 0.36 of the
/// thickness.
///
/// @return V x [units]
Eigen::VectorXd EdgeSizes(const Mesh& surface, const SizeRules& rules);

/// Halves the sizes within `reach` edge lengths of the given places.
void Refine(const Mesh& surface, const PointsX3& places, double reach, Eigen::VectorXd& sizes);

}  // namespace keypose::cleanup
