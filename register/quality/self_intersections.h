// Faces of a mesh that pass through each other.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh.h"

namespace keypose::registration {

struct SelfIntersections {
  std::int64_t pairs = 0;  ///< unordered pairs of faces that meet although they share no vertex
  std::vector<int> faces;  ///< faces that are in some pair, ascending
};

/// Pairs of faces without a common vertex (by index) whose closed triangles have a common point;
/// touching counts. Two faces that share a vertex or an edge are never a pair, even where they fold
/// over each other: flipped faces count those.
///
/// The answer is exact for the given coordinates: signs that rounding could change are decided by
/// exact arithmetic. Faces without area count as the segment or point that they are.
/// @throws InputError  an index out of range, or a vertex that is not finite
/// Cost: near-linear; 5 ms at 10,000 faces.
/// Same bits for any thread count.
/// Source: Guigue and Devillers, Fast and Robust Triangle-Triangle Overlap Test, 2003.
SelfIntersections FindSelfIntersections(const PointsX3& points, const FacesX3& faces);

}  // namespace keypose::registration
