// Colours of faces as colours of vertices.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// For a warning where TakeFaceColors blends.
inline constexpr const char* kColorsBlend =
    "colours of its faces become those of its vertices, and blend where faces of different "
    "colours meet";

/// Gives each vertex the mean colour of its faces. Vertices without any take their neighbours'
/// (some_colors.h). Without coloured faces the mesh stays.
/// @param levels  F x 3, sRGB from 0 to 255; not a number: the face has no colour
/// @return whether any vertex lies on faces of different colours
bool TakeFaceColors(const Eigen::MatrixX3d& levels, Mesh* mesh);

}  // namespace keypose
