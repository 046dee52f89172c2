// The texture that belongs to a mesh file: an OBJ's material names it, and so may a PLY's comment.
#pragma once

#include <filesystem>
#include <string>

namespace keypose {

struct MeshTexture {
  std::filesystem::path file;  ///< empty: none, or it cannot be used
  std::string why;  ///< what keeps it from being used, for a warning; empty where none is named
};

/// Finds it by `mtllib`, `usemtl` and `map_Kd` (OBJ), or by `comment TextureFile` (PLY, as MeshLab
/// writes it). It must lie in the mesh's folder or below: of a path that leads elsewhere, the file
/// of that name beside the mesh is taken.
/// @throws DiskError  the mesh cannot be opened
MeshTexture FindTexture(const std::filesystem::path& mesh);

}  // namespace keypose
