// A pole that stands on a disc.
#pragma once

#include "cleanup/testing/damaged_meshes.h"
#include "core/values/mesh.h"

namespace keypose::cleanup {

/// A pole of radius 0.1 and height 1 that grows out of a disc of thickness 0.03: one surface of
/// revolution.
inline Mesh PoleOnDisc(double disc_radius) {
  return MakeRevolved({{0.1, 1},
                       {0.1, 0.8},
                       {0.1, 0.6},
                       {0.1, 0.4},
                       {0.1, 0.2},
                       {0.1, 0.06},
                       {0.1, 0.03},
                       {0.5 * (0.1 + disc_radius), 0.03},
                       {disc_radius, 0.03},
                       {disc_radius, 0}},
                      48);
}

}  // namespace keypose::cleanup
