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

/// A mesh in another pose. A polygon that bends is cut by its corners' places (polygon_cut.h), so
/// that OBJ files of the same polygons need not have the same triangles: those of `first` are taken
/// where they cover these polygons, and texture coordinates alike. None are left if a polygon that
/// has a vertex twice is cut anew. Otherwise the mesh is what ReadMesh gives; callers compare the
/// faces (same_faces.h).
/// @throws DiskError, InputError  as ReadMesh
Mesh ReadMeshCutAs(const std::filesystem::path& path, const Mesh& first);

/// Writes an OBJ as WriteMesh does, but with polygons, so that reading it gives the same again.
/// @throws InputError  the polygons are not those of the mesh
/// @throws DiskError   as WriteMesh
void WritePolygonObj(const std::filesystem::path& path, const PolygonMesh& mesh,
                     const std::string& material_texture = "");

}  // namespace keypose
