// Points of a cloud kept or dropped, in place.
#pragma once

#include <vector>

#include "core/mesh.h"

namespace keypose::reconstruct {

/// Moves the points that are kept up, with all that is known of them, and frees the rest. Without a
/// second cloud in memory.
/// @param keep   one for each point
/// @param cloud  with normals, colours and confidence
/// @return how many went
int KeepRows(const std::vector<char>& keep, PointCloud* cloud);

}  // namespace keypose::reconstruct
