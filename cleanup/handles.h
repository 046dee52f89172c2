// Handles and tunnels that a surface should not have: found by their shortest loop, cut through, and closed.
#pragma once

#include <vector>

#include "core/mesh.h"

namespace keypose::cleanup {

/// Handles of all pieces together. @param closed  closed oriented 2-manifold
int Genus(const Mesh& closed);

/// Loops that no cut of the surface in two contains, two for each handle: round it or through it, each as short as through its own
/// vertices.
///
/// @return vertex ids in order; shortest loop first; empty for spheres
/// Source: Erickson & Whittlesey, SODA 2005 (shortest paths and the longest dual tree leave two edges a handle); here each of the shortest
/// loops becomes the root once more, until none gets shorter.
std::vector<std::vector<int>> HandleLoops(const Mesh& closed);

struct HandlesResult {
  Mesh mesh;    ///< closed, without self-intersections if the input had none
  int cut = 0;  ///< handles that went
};

/// Removes handles until `genus` are left, the one with the shortest loop first. A strip along the loop is taken out and both rims get a
/// membrane: a loop round a bridge cuts the bridge, a loop round a hole's rim fills the hole; whichever is shorter. Nothing else moves.
/// Loops whose membranes would cross anything are passed over, so that more handles may stay: look at Genus of the result.
HandlesResult WithoutHandles(const Mesh& closed, int genus);

}  // namespace keypose::cleanup
