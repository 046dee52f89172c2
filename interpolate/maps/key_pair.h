// Two keys at the door.
#pragma once

#include "core/mesh.h"

namespace keypose::interpolation {

/// @throws InputError  other numbers of vertices, or a key that no algorithm can use (see
/// RequireUsable)
void RequireKeys(const PointsX3& v, const PointsX3& u, const FacesX3& faces);

}  // namespace keypose::interpolation
