// Puts a solid's inner points where its surface in another pose wants them.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "interpolate/volume/tet_maps.h"
#include "interpolate/volume/tetrahedralize.h"

namespace keypose::interpolation {

/// All points of the solid in the pose whose surface is `surface`: its first V points bit for bit,
/// the inner ones by a volumetric as-rigid-as-possible fit. The fit starts from the surface's own
/// turns, spread into the solid as a harmonic field, so a twist or a curl of any angle starts near
/// its goal; up to 100 rounds of local turns and one global solve follow. Then, only where
/// tetrahedra are still inside out, their inner points are moved by Newton steps on an energy
/// without fold-overs, point by point. Tetrahedra whose four corners all lie on the surface cannot
/// be helped. Deterministic, same bits for any thread count.
///
/// @param shapes   of solid.tets in the solid's own pose
/// @param surface  V x 3
/// @throws SolverError
/// Source: Sorkine and Alexa, SGP 2007, on tetrahedra (Chao et al. 2010); Garanzha et al.,
/// Foldover-free maps in 50 lines of code, TOG 2021. Departs from the latter: one point at a time
/// with an exact 3 x 3 Hessian, since a handful of places need it.
PointsX3 PlaceInside(const Solid& solid, const std::vector<TetShape>& shapes, const FacesX3& faces,
                     const PointsX3& surface);

/// The untangling alone, in place; points below `fixed` stay.
/// @return tetrahedra that are still flat or inside out
int Untangle(const Solid& solid, const std::vector<TetShape>& shapes, Eigen::Index fixed,
             PointsX3& points);

}  // namespace keypose::interpolation
