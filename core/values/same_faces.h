// Whether two meshes have the same faces.
#pragma once

#include "core/values/mesh.h"

namespace keypose {

/// Faces, or texture faces, of two meshes, also of different numbers: Eigen's comparison reads
/// beyond the end of the smaller one.
inline bool SameFaces(const FacesX3& a, const FacesX3& b) { return a.rows() == b.rows() && a == b; }

}  // namespace keypose
