// Keeps or drops points of a cloud, in place.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose::reconstruct {

/// Moves the kept points to the front, with all their attributes, and frees the rest, without a
/// second cloud in memory.
/// @param keep   one per point
/// @param cloud  with normals, colours and confidence
/// @return number of removed points
int KeepRows(const std::vector<char>& keep, PointCloud* cloud);

}  // namespace keypose::reconstruct
