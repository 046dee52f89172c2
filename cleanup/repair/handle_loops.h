// The number of handles of closed surfaces, and the loops around and through them.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose::cleanup {

/// The number of handles of all pieces together.
/// @param closed  closed oriented 2-manifold
int Genus(const Mesh& closed);

/// Short loops around and through the handles, two or more for each handle. None of them divides
/// the surface.
///
/// @return vertex ids in order; shortest loop first; empty for spheres
/// Source: Erickson & Whittlesey, SODA 2005 (the shortest paths and the longest dual tree leave two
/// edges for each handle). In addition, vertices of the shortest loops become new roots until no
/// loop gets shorter.
std::vector<std::vector<int>> HandleLoops(const Mesh& closed);

/// A basis of the loops of the surface: two for each handle, in no particular order, and not
/// shortened.
std::vector<std::vector<int>> LoopBasis(const Mesh& closed);

/// Length of a closed loop of vertices.
double LoopLength(const Mesh& mesh, const std::vector<int>& loop);

}  // namespace keypose::cleanup
