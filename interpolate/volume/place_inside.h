// Inner points of a solid for another pose of its surface.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "interpolate/volume/tet_maps.h"
#include "interpolate/volume/tetrahedralize.h"

namespace keypose::interpolation {

/// All points of the solid in the pose whose surface is `surface`: its first V points bit for bit,
/// the inner ones by a volumetric as-rigid-as-possible fit. The fit starts from the surface's own
/// rotations, extended into the solid as a harmonic field, so that a twist or a curl of any angle
/// starts near its goal. Up to 100 rounds of local rotations and a global solve follow. Where
/// tetrahedra are still inverted, Newton steps then move their inner points one by one, on an
/// energy without fold-overs. Tetrahedra with all four corners on the surface cannot be repaired.
/// Deterministic, same bits for any thread count.
///
/// @param shapes   of solid.tets in the solid's own pose
/// @param surface  V x 3
/// @throws SolverError
/// Source: Sorkine and Alexa, SGP 2007, on tetrahedra (Chao et al. 2010); Garanzha et al.,
/// Foldover-free maps in 50 lines of code, TOG 2021. Departs from the latter: one point at a time
/// with an exact 3 x 3 Hessian, since only a few places need it.
PointsX3 PlaceInside(const Solid& solid, const std::vector<TetShape>& shapes, const FacesX3& faces,
                     const PointsX3& surface);

/// The untangling alone, in place; points below `fixed` do not move.
/// @return number of tetrahedra that are still flat or inverted
int Untangle(const Solid& solid, const std::vector<TetShape>& shapes, Eigen::Index fixed,
             PointsX3& points);

}  // namespace keypose::interpolation
