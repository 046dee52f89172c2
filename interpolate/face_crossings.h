// Where a surface passes through itself.
#pragma once

#include <optional>
#include <utility>

#include "core/mesh.h"

namespace keypose::interpolation {

/// The first pair of faces without a common vertex of which one has an edge through the other (in order of the first face's lowest x), or
/// nothing. For messages: rounding can hide a mere touch. Cost: a sweep along x.
std::optional<std::pair<int, int>> FirstCrossing(const PointsX3& points, const FacesX3& faces);

}  // namespace keypose::interpolation
