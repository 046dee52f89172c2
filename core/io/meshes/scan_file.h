// A mesh of another program with its look: one layout and one texture, or colours of vertices.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/polygons.h"

namespace keypose {

struct Scan {
  Mesh mesh;
  Polygons polygons;           ///< of an OBJ that has any but triangles; else empty
  std::string texture;         ///< the picture file's bytes; empty: none that can be used
  std::string texture_ending;  ///< ".png" and so on
  /// Where the texture is a file of its own and stays as it is. Empty: it was inside, or was made.
  std::filesystem::path texture_file;
  /// Whether ReadMesh of the same file gives another mesh, so that this one must be written.
  bool changed = false;
  std::string unit;  ///< in which its format has lengths: "m"; empty: the file does not say
  /// Sentences about what the mesh does not have although the file has it.
  std::vector<std::string> warnings;
};

/// Reads PLY, OBJ, OFF, STL and glTF by content, with the textures that they name:
/// glTF as in glb_mesh.h; OBJ by `mtllib`, `usemtl` and `map_Kd` with its options; PLY by
/// `comment TextureFile` and `texnumber`, as MeshLab writes them. Files must lie in the mesh's
/// folder or below: of a path that leads elsewhere, the file of that name beside the mesh is taken.
/// Several textures become one. Where there is none, materials' colours become those of the
/// vertices. Of a ZIP file the mesh in it is read (zipped_scan.h).
/// @param join_seams  as ReadGlb
/// @throws DiskError, InputError  as ReadMesh
Scan ReadScan(const std::filesystem::path& path, bool join_seams = true);

/// The same mesh for a texture that is given apart: with the coordinates that its file has, and
/// without a texture.
/// @throws DiskError, InputError  as ReadMesh
Scan ReadScanWithoutLook(const std::filesystem::path& path, bool join_seams = true);

}  // namespace keypose
