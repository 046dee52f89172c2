// Which handles of a surface the photographs see through: background behind a window is no noise.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "core/sight_lines.h"

namespace keypose::cleanup {

/// How many handles the lines tell from each other, each in two views at least: the rank of the
/// linking numbers between lines that meet nothing and the loops of the surface. A line links with
/// a loop when the loop winds round its pixel.
///
/// @param closed  closed oriented 2-manifold; at most Genus(closed) are seen through
int HandlesSeenThrough(const Mesh& closed, const std::vector<SightLine>& lines);

}  // namespace keypose::cleanup
