// Checks of two keys.
#pragma once

#include "core/values/mesh.h"

namespace keypose::interpolation {

/// @throws InputError  the keys differ in their number of vertices, or a key is unusable (see
/// RequireUsable)
void RequireKeys(const PointsX3& v, const PointsX3& u, const FacesX3& faces);

}  // namespace keypose::interpolation
