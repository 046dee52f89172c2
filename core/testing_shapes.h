// Analytic shapes for tests and benchmarks in all rooms.
#pragma once

#include <vector>

#include "core/mesh.h"

namespace keypose {

/// A closed sphere of unit radius: an icosahedron whose faces are split `levels` times. 20 *
/// 4^levels faces.
Mesh MakeIcosphere(int levels);
/// A closed axis-aligned box with corners at the origin and (x, y, z). 12 faces.
Mesh MakeBox(double x, double y, double z);
/// A closed tube along z with `rings` x `segments` quads on its side, each split in two, and a fan
/// as cap at each end. Radius and length in metres.
Mesh MakeCylinder(double radius, double length, int segments, int rings);
/// The mesh in two charts, below and above the height z, each with vertices of its own, as PLY and
/// glTF files need it for texture coordinates. Faces keep their numbers.
/// @param origin  vertex of the whole mesh for each one; may be null
Mesh CutInCharts(const Mesh& whole, double z, std::vector<int>* origin = nullptr);

}  // namespace keypose
