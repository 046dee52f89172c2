// Meshes and clouds in PLY files; mesh_io.h reads them among others.
#pragma once

#include <filesystem>

#include "core/values/mesh.h"

namespace keypose {

/// Texture coordinates are those of the faces' corners (`texcoord`), or else of the vertices
/// (`s t`, `u v` or `texture_u texture_v`).
/// @throws InputError  as ReadMesh
Mesh ReadPlyMesh(const std::filesystem::path& path);
/// @throws InputError  as ReadPointCloud
PointCloud ReadPlyCloud(const std::filesystem::path& path);

}  // namespace keypose
