// Fills the holes of an oriented manifold: small ones follow the curvature of their surroundings,
// large ones become flat membranes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/progress.h"

namespace keypose::cleanup {

struct HolesResult {
  Mesh mesh;  ///< closed when the input was an oriented manifold
  int filled = 0;
  int fanned = 0;  ///< of these, filled by a simple fan because no better triangulation was found
  /// extent of the largest hole's bounding box over that of the mesh
  double largest_over_diag = 0;
};

/// Fills all holes.
///
/// @param manifold    oriented 2-manifold, possibly with boundary
/// @param large_hole  size limit between small and large holes, over the diagonal
/// Holes up to `large_hole` are refined and faired with continuous tangents. Larger ones, such as
/// the base that stood on the turntable, get a membrane of least area over their rim, which is flat
/// when the rim is flat. Small holes with a planar rim, such as a cut leaves, get a flat cap too.
/// Source: Liepa, SGP 2003 (triangulation, refinement), Botsch & Kobbelt, SIGGRAPH 2004 (fairing),
/// both by CGAL.
HolesResult FillHoles(const Mesh& manifold, Progress* progress, double large_hole = 0.1);

/// Whether a hole's corners, in order, keep apart in the projection of CGAL's planar triangulation,
/// by 1e-9 of `extent`, the hole's size. Only then it is used.
bool ApartInPlanarView(const std::vector<Eigen::Vector3d>& rim, double extent);

}  // namespace keypose::cleanup
