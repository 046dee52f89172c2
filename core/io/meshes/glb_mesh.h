// Reads the mesh and the textures of a glTF (.glb, .gltf), as scanning apps and modelling programs
// export them. docs/scans.md lists what of the format is read.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/meshes/texture_pages.h"
#include "core/values/mesh.h"

namespace keypose {

struct GlbMesh {
  /// All triangles of the scene, z up. Without pages, the materials' colours and those of the
  /// vertices are the mesh's.
  PagedMesh paged;
  /// Sentences about what the mesh does not have although the file has it.
  std::vector<std::string> warnings;
};

/// Places all meshes of the scene by their nodes, or by their skins, with the shapes that the file
/// switches on; in the pose that is filed, not that of an animation.
/// @param join_seams  vertices that are doubled where charts of the texture end become one; meshes
///                    that differ by pose then need not have the same numbers
/// @throws DiskError   the file cannot be read
/// @throws InputError  it is no glTF, is damaged, has no triangles, or needs an extension that is
///                     not read
GlbMesh ReadGlb(const std::filesystem::path& path, bool join_seams = true);

}  // namespace keypose
