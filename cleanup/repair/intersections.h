// Finds and removes self-intersections of a triangle mesh, with exact predicates.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose::cleanup {

/// Whether any two faces meet outside of a shared vertex or edge, or a face has no area.
/// @param mesh  an oriented 2-manifold
bool SelfIntersects(const Mesh& mesh);

/// Faces that take part in such an intersection, ascending.
std::vector<int> IntersectingFaces(const Mesh& mesh, int* pairs = nullptr);

/// The mesh without these faces and `rings` rings of faces around them. All vertices stay, also
/// unused ones.
Mesh Without(const Mesh& mesh, const std::vector<int>& faces, int rings);

/// Removes the neighbourhoods of intersections and fills the holes. Each round removes wider
/// neighbourhoods.
/// @return a mesh that may still intersect itself, or without faces: check it
Mesh WithoutIntersections(const Mesh& closed, int rounds);

}  // namespace keypose::cleanup
