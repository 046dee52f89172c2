// Removes handles and tunnels that a surface should not have: cuts along their shortest loops and
// closes the holes.
#pragma once

#include <vector>

#include "core/pictures/sight_lines.h"
#include "core/values/mesh.h"

namespace keypose::cleanup {

struct HandlesResult {
  Mesh mesh;                    ///< closed, without self-intersections if the input had none
  int cut = 0;                  ///< handles that were removed
  std::vector<double> lengths;  ///< of the loop along which each was cut
};

/// Removes handles until `genus` are left. The handle with the shortest loop is removed first. The
/// faces along the loop are removed, and a membrane closes each of the two rims. A loop around a
/// bridge cuts the bridge; a loop around a hole fills the hole. The shorter one is used. The rest
/// of the surface does not change. Loops whose membranes would intersect the surface are skipped,
/// so more handles may stay: check Genus of the result. Handles through which `lines` pass
/// (HandlesSeenThrough) stay; up to `genus` of them.
HandlesResult WithoutHandles(const Mesh& closed, int genus,
                             const std::vector<SightLine>& lines = {});

}  // namespace keypose::cleanup
