// Loops of closed surfaces: how many handles a surface has, and the loops round and through them.
#pragma once

#include <vector>

#include "core/mesh.h"

namespace keypose::cleanup {

/// Handles of all pieces together.
/// @param closed  closed oriented 2-manifold
int Genus(const Mesh& closed);

/// Loops that no cut of the surface in two contains, two for each handle: round it or through it,
/// each as short as through its own vertices.
///
/// @return vertex ids in order; shortest loop first; empty for spheres
/// Source: Erickson & Whittlesey, SODA 2005 (shortest paths and the longest dual tree leave two
/// edges a handle); here each of the shortest loops becomes the root once more, until none gets
/// shorter.
std::vector<std::vector<int>> HandleLoops(const Mesh& closed);

/// Two loops for each handle that together tell all loops of the surface, in no order; as long as
/// they come.
std::vector<std::vector<int>> LoopBasis(const Mesh& closed);

/// Of a closed loop of vertices.
double LoopLength(const Mesh& mesh, const std::vector<int>& loop);

}  // namespace keypose::cleanup
