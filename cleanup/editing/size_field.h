// Wanted edge lengths over a surface, so that a given number of faces represents the shape best.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh.h"

namespace keypose::cleanup {

struct SizeRules {
  int faces = 20000;             ///< number of faces that the sizes should give
  bool follow_curvature = true;  ///< false: equal sizes, except on thin limbs
  double exponent = 1.0 / 3;     ///< sizes are proportional to curvature^-exponent
  double smallest =
      0.3;  ///< lower limit in curved places, relative to the edge length of equal triangles
  double largest = 2;  ///< upper limit in flat places, likewise
  double limb_smallest =
      0.15;             ///< lower limit on limbs that are thinner than the triangles, likewise
  double growth = 0.6;  ///< largest change of size per length along the surface
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
