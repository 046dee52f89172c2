// Analytic shapes for tests and benchmarks of every room.
#pragma once

#include "core/mesh.h"

namespace keypose {

/// Closed sphere of unit radius from an icosahedron whose faces are split `levels` times; 20 *
/// 4^levels faces.
Mesh MakeIcosphere(int levels);
/// Closed axis-aligned box with corners at the origin and (x, y, z); 12 faces.
Mesh MakeBox(double x, double y, double z);
/// Closed tube along z with `rings` x `segments` side quads split in two, capped by fans; radius
/// and length in metres.
Mesh MakeCylinder(double radius, double length, int segments, int rings);

}  // namespace keypose
