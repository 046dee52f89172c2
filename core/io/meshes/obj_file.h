// Wavefront OBJ: polygons, their texture coordinates and materials' names, colours of vertices.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/polygons.h"

namespace keypose {

struct ObjFile {
  /// Polygons cut into triangles (polygon_cut.h); uvs where any corner has some (others get (0,
  /// 0)); colours where any vertex has one (others take their neighbours').
  Mesh mesh;
  Polygons polygons;                   ///< whose triangles the mesh has; empty: triangles alone
  std::vector<std::string> libraries;  ///< what stands behind each `mtllib`
  /// Of the faces; "" for faces before any `usemtl`.
  std::vector<std::string> materials;
  std::vector<int> material_of_face;  ///< F, into materials
  bool has_texture_maps = false;      ///< `usemap`, which names a texture without a material
  std::vector<std::string> left_out;  ///< parts of sentences about statements that are not read
};

/// Reads positions `v x y z`, with a weight (`v x y z w`, which polygons do not use), a colour
/// (`v x y z r g b`), or both (`v x y z w r g b`, or alpha last); `#MRGB` colours of ZBrush, and
/// `vc r g b`, one for each vertex; indices from 1 or backwards; lines continued by a backslash.
/// @throws DiskError   cannot be opened
/// @throws InputError  malformed, an index out of range, or what is not read: free-form surfaces
///                     (`surf`), `call`, `csh`; says where
ObjFile ReadObj(const std::filesystem::path& path);

}  // namespace keypose
