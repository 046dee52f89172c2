// Handles and tunnels that a surface should not have: found by their shortest loop, cut through, and closed.
#pragma once

#include <vector>

#include "cleanup/see_through.h"
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

/// Two loops for each handle that together tell all loops of the surface, in no order; as long as they come.
std::vector<std::vector<int>> LoopBasis(const Mesh& closed);

struct HandlesResult {
  Mesh mesh;                    ///< closed, without self-intersections if the input had none
  int cut = 0;                  ///< handles that went
  std::vector<double> lengths;  ///< of the loop that each was cut along
};

/// Removes handles until `genus` are left, the one with the shortest loop first. A strip along the loop is taken out and both rims get a
/// membrane: a loop round a bridge cuts the bridge, a loop round a hole's rim fills the hole; whichever is shorter. Nothing else moves.
/// Loops whose membranes would cross anything are passed over, so that more handles may stay: look at Genus of the result. Handles that
/// `lines` see through (HandlesSeenThrough) stay as long as others can go.
HandlesResult WithoutHandles(const Mesh& closed, int genus, const std::vector<SightLine>& lines = {});

}  // namespace keypose::cleanup
