// Meshes and clouds in PLY files; mesh_io.h reads them among others.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// Faces are `vertex_indices` or `vertex_index` of `face`, and strips of `tristrips`. Texture
/// coordinates are those of the faces' corners (`texcoord`), or else of the vertices (`s t`, `u v`,
/// `texture_u texture_v`). Colours are those of the vertices, else the means of the faces': three
/// numbers, or one of packed bits (`rgb`, `rgba`), as PCL writes it.
/// @throws InputError  as ReadMesh
Mesh ReadPlyMesh(const std::filesystem::path& path);

/// A mesh whose faces show several textures, as MeshLab writes them (`texnumber`).
struct PlyPages {
  Mesh mesh;
  std::vector<int> page_of_face;  ///< F, into the `comment TextureFile` lines; empty: all the first
  std::vector<std::string> notes;  ///< parts of sentences about what is left out
};
/// @throws InputError  as ReadMesh
PlyPages ReadPlyPages(const std::filesystem::path& path);

/// @throws InputError  as ReadPointCloud
PointCloud ReadPlyCloud(const std::filesystem::path& path);

}  // namespace keypose
