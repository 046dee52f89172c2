// Geomview's OFF: polygons with colours of vertices or faces, as text and binary.
#pragma once

#include <filesystem>
#include <string_view>

#include "core/io/meshes/noted_mesh.h"

namespace keypose {

/// Whether a text begins with a keyword of OFF: `OFF`, `COFF`, `STNOFF`, `4nOFF` and so on, of any
/// case, behind comments; the first number may follow at once. `o coffee cup` of an OBJ does not.
bool LooksLikeOff(std::string_view head);

/// Reads `[ST][C][N][4][n]OFF [BINARY]`. Normals are kept, and so are texture coordinates. Colours
/// of vertices have one, three or four numbers, from 0 to 1 or whole ones to 255; those of faces
/// are taken where vertices have none (face_colors.h). Numbers of a colour map and blended colours
/// are noted. Binary files may be of either byte order, and count the numbers of a vertex's colour
/// (CGAL) or not (Geomview).
/// @throws DiskError   cannot be opened
/// @throws InputError  malformed, truncated, of other than three dimensions; says where
NotedMesh ReadOff(const std::filesystem::path& path);

}  // namespace keypose
