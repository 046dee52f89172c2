// Where a surface passes through itself, and how to part it.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "core/mesh.h"

namespace keypose::interpolation {

/// Pairs of faces, lower first, of which one has an edge through the other, in order of the later
/// face's lowest x. Neighbours across an edge are not compared. Rounding can hide a mere touch.
/// Cost: a sweep along x.
std::vector<std::pair<int, int>> Crossings(const PointsX3& points, const FacesX3& faces);

/// The surface with its crossings smoothed away: faces that cross, and a few rings around them,
/// shrink towards their neighbours until nothing crosses.
/// @return nothing where that does not help,
/// or would move more than a tenth of the vertices
std::optional<PointsX3> WithoutCrossings(const PointsX3& points, const FacesX3& faces);

}  // namespace keypose::interpolation
