// Meshes with the polygons of their files, which mesh_io.h reads as triangles.
#pragma once

#include <filesystem>
#include <string>

#include "core/values/mesh.h"
#include "core/values/polygons.h"

namespace keypose {

struct PolygonMesh {
  Mesh mesh;
  Polygons polygons;  ///< of an OBJ; empty: of another kind of file, or it has triangles alone
};

/// The mesh that ReadMesh gives, and its polygons.
/// @throws DiskError, InputError  as ReadMesh
PolygonMesh ReadPolygonMesh(const std::filesystem::path& path);

/// Writes an OBJ as WriteMesh does, but with polygons, so that reading it gives the same again.
/// @throws InputError  the polygons are not those of the mesh
/// @throws DiskError   as WriteMesh
void WritePolygonObj(const std::filesystem::path& path, const PolygonMesh& mesh,
                     const std::string& material_texture = "");

}  // namespace keypose
