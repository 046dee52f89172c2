// Where a surface intersects itself, and how to remove the intersections.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::interpolation {

/// Pairs of faces of which one has an edge through the other, the lower index first. Pairs are in
/// order of the lowest x of the face that the sweep meets later. Neighbours across an edge are not
/// compared. Rounding can hide a mere touch.
/// Cost: a sweep along x.
std::vector<std::pair<int, int>> Crossings(const PointsX3& points, const FacesX3& faces);

/// The surface with its crossings smoothed away: faces that cross, and a few rings of faces around
/// them, shrink towards their neighbours until nothing crosses.
/// @return nothing if crossings remain, or if more than a tenth of the vertices would move
std::optional<PointsX3> WithoutCrossings(const PointsX3& points, const FacesX3& faces);

}  // namespace keypose::interpolation
