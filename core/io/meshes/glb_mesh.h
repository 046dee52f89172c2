// Reads the mesh and the texture of a binary glTF (.glb), as scanning apps and modelling programs
// export them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

struct GlbMesh {
  Mesh mesh;  ///< all triangles of the scene, z up
  /// The colour texture's file as it lies in the GLB; empty: none, or not one that can be used
  std::string texture;
  std::string texture_ending;  ///< ".png" or ".jpg"
  /// Sentences about what the mesh does not have although the file has it.
  std::vector<std::string> warnings;
};

/// Places all meshes of the scene by their nodes. Skins, morph targets and animations are left out.
/// Where there is no texture, the materials' colours become those of the vertices.
/// @param join_seams  vertices that are doubled where charts of the texture end become one; meshes
///                    that differ by pose then need not have the same numbers
/// @throws DiskError   the file cannot be read
/// @throws InputError  it is no GLB, is damaged, has no triangles, or needs an extension (Draco)
GlbMesh ReadGlb(const std::filesystem::path& path, bool join_seams = true);

}  // namespace keypose
