// Handles and tunnels that a surface should not have: found by their shortest loop, cut through,
// and closed.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "core/sight_lines.h"

namespace keypose::cleanup {

struct HandlesResult {
  Mesh mesh;                    ///< closed, without self-intersections if the input had none
  int cut = 0;                  ///< handles that went
  std::vector<double> lengths;  ///< of the loop that each was cut along
};

/// Removes handles until `genus` are left, the one with the shortest loop first. A strip along the
/// loop is taken out and both rims get a membrane: a loop round a bridge cuts the bridge, a loop
/// round a hole's rim fills the hole; whichever is shorter. Nothing else moves. Loops whose
/// membranes would cross anything are passed over, so that more handles may stay: look at Genus of
/// the result. Handles that `lines` see through (HandlesSeenThrough) stay as long as others can go.
HandlesResult WithoutHandles(const Mesh& closed, int genus,
                             const std::vector<SightLine>& lines = {});

}  // namespace keypose::cleanup
