// Chooses which of two keys is filled with tetrahedra.
#pragma once

#include "core/values/mesh.h"

namespace keypose::interpolation {

/// Whether the second key is the smoother one (less bending energy). Swapping the keys selects the
/// same key.
bool SecondIsSmoother(const PointsX3& v, const PointsX3& u, const FacesX3& faces);

}  // namespace keypose::interpolation
