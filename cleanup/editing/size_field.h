// How long edges should be, place by place, so that a wanted number of faces shows the shape best.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh.h"

namespace keypose::cleanup {

struct SizeRules {
  int faces = 20000;             ///< triangles of these sizes that cover the surface
  bool follow_curvature = true;  ///< false: equal sizes, save on thin limbs
  double exponent = 1.0 / 3;     ///< of the curvature that sizes go with the inverse of
  double smallest = 0.3;         ///< over the size of equal triangles, where the surface bends
  double largest = 2;            ///< the same, where it is flat
  double limb_smallest = 0.15;   ///< the same, on limbs thinner than the triangles
  double growth = 0.6;           ///< change of size per length along the surface, at most
};

/// Larger principal curvature at each vertex, by size. Scale: about an edge of the mesh.
///
/// @return V x [1/units]
/// Source: Rusinkiewicz, 3DPVT 2004 (differences of normals over faces).
/// Departs: no frames, and root mean square over the fan.
Eigen::VectorXd MaxCurvature(const Mesh& surface);

/// How thick the body is below each vertex: the way inwards to the other side; infinite where none
/// is met. V x [units]
Eigen::VectorXd Thickness(const Mesh& surface);

/// Wanted edge length at each vertex of a closed surface: in proportion to curvature^-exponent,
/// between bounds and for the wanted count. At 1/3 the mean squared distance of the triangles is
/// least, at 1/2 they are all equally far. Round limbs get at least eight faces round them: no edge
/// above 0.36 of the thickness.
///
/// @return V x [units]
Eigen::VectorXd EdgeSizes(const Mesh& surface, const SizeRules& rules);

/// Halves the sizes within `reach` edge lengths of the places.
void Refine(const Mesh& surface, const PointsX3& places, double reach, Eigen::VectorXd& sizes);

}  // namespace keypose::cleanup
