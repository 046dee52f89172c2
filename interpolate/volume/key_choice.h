// Which of two keys to fill with tetrahedra.
#pragma once

#include "core/mesh.h"

namespace keypose::interpolation {

/// Whether the second key is the smoother one (less bending energy). A rule that names the same key
/// when the two change places.
bool SecondIsSmoother(const PointsX3& v, const PointsX3& u, const FacesX3& faces);

}  // namespace keypose::interpolation
