// A mesh as files with texture coordinates have it.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// The mesh in two charts, below and above the height z, each with vertices of its own, as PLY and
/// glTF files need it for texture coordinates. Faces keep their numbers.
/// @param origin  vertex of the whole mesh for each one; may be null
Mesh CutInCharts(const Mesh& whole, double z, std::vector<int>* origin = nullptr);

}  // namespace keypose
