// Analytic shapes: of known volume, area and curvature.
#pragma once

#include "core/values/mesh.h"

namespace keypose {

/// A closed sphere of unit radius: an icosahedron whose faces are split `levels` times. 20 *
/// 4^levels faces.
Mesh MakeIcosphere(int levels);
/// A closed axis-aligned box with corners at the origin and (x, y, z). 12 faces.
Mesh MakeBox(double x, double y, double z);
/// A closed tube along z with `rings` x `segments` quads on its side, each split in two, and a fan
/// as cap at each end. Radius and length in metres.
Mesh MakeCylinder(double radius, double length, int segments, int rings);

}  // namespace keypose
