// The size of a surface that may have holes.
#pragma once

#include "core/values/mesh.h"

namespace keypose::registration {

/// Surface area with each boundary loop closed by a disc of the same circumference.
/// @param filled  receives the discs' share of the result
double WholeArea(const Mesh& mesh, double& filled);

}  // namespace keypose::registration
