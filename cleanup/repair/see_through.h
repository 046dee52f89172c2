// Counts the handles of a surface that photographs see through. These are real and not noise.
#pragma once

#include <vector>

#include "core/pictures/sight_lines.h"
#include "core/values/mesh.h"

namespace keypose::cleanup {

/// The number of handles that the lines of sight distinguish, each in at least two views. It is the
/// rank of the matrix of linking numbers between unblocked lines and loops of the surface. A line
/// is linked with a loop when the loop, seen from the camera, winds around the line's pixel.
///
/// @param closed  closed oriented 2-manifold
/// @return at most Genus(closed)
int HandlesSeenThrough(const Mesh& closed, const std::vector<SightLine>& lines);

}  // namespace keypose::cleanup
