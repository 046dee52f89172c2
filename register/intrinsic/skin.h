// One surface around a body that is made of several overlapping closed pieces, such as the tracked
// body of a performance: distances along the surface need one that goes from limb to limb.
#pragma once

#include <optional>

#include "core/values/mesh.h"

namespace keypose::registration {

struct SkinOptions {
  int cells = 96;            ///< along the longest side of the bounding box, 16 to 512
  double whole_share = 0.7;  ///< a mesh whose largest piece has more of the area needs no skin
};

/// @return a closed, oriented 2-manifold around all closed pieces, within about a cell of them;
/// none where one piece is most of the mesh.
/// Cost: linear in the cells of the box. Deterministic.
/// Source: tetrahedra of a grid cut between inside and outside (Doi and Koide, 1991), smoothed.
std::optional<Mesh> SkinOfPieces(const Mesh& mesh, const SkinOptions& options = {});

}  // namespace keypose::registration
