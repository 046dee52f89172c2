// Fills the holes of an oriented manifold: small ones with the curvature of their surroundings,
// large ones as tight membranes.
#pragma once

#include "core/mesh.h"
#include "core/progress.h"

namespace keypose::cleanup {

struct HolesResult {
  Mesh mesh;  ///< closed when the input was an oriented manifold
  int filled = 0;
  int fanned = 0;  ///< of those, filled by a plain fan because no better triangulation was found
  /// extent of the largest hole's bounding box over that of the mesh
  double largest_over_diag = 0;
};

/// @param manifold  oriented 2-manifold, possibly with boundary
/// @param large_hole  over the diagonal
/// Holes up to `large_hole` are refined and faired with continuous tangents; larger ones (the base
/// that stood on the turntable) become a membrane of least area over their rim, which is flat where
/// the rim is flat. Small holes whose rim lies in a plane, as a cut leaves it, get a flat cap too.
/// Source: Liepa, SGP 2003 (triangulation, refinement), Botsch & Kobbelt, SIGGRAPH 2004 (fairing),
/// both by CGAL.
HolesResult FillHoles(const Mesh& manifold, Progress* progress, double large_hole = 0.1);

}  // namespace keypose::cleanup
