// Reads meshes and point clouds by content (PLY, OBJ, OFF, STL, glTF) and writes them by file name.
#pragma once

#include <filesystem>
#include <string>

#include "core/values/mesh.h"

namespace keypose {

enum class MeshKind { kPly, kObj, kOff, kStl, kGltf, kZip };

/// The kind of a mesh file, judged by its first bytes; its name does not matter.
/// @throws DiskError   cannot be opened
/// @throws InputError  not one of the formats; says what it is, where that is known
MeshKind MeshKindOf(const std::filesystem::path& path);

/// Reads a triangle mesh; polygons are split into fans of triangles. Vertices and faces keep the
/// order of the file (STL: corners with equal coordinates become one vertex). Reads positions,
/// vertex normals (PLY), vertex colours and texture coordinates (OBJ `vt`, where faces without any
/// get (0, 0); of PLY see ply_mesh.h, of glTF glb_mesh.h). Materials and textures: scan_file.h.
/// @throws DiskError   cannot be opened
/// @throws InputError  not one of the formats, or a ZIP file; truncated, an index out of range;
/// says
///                     where
Mesh ReadMesh(const std::filesystem::path& path);

/// Checks the name of a mesh that is yet to be written, before the work for it begins.
/// @throws UsageError  it is neither .ply nor .obj
void RequireMeshName(const std::filesystem::path& path);

/// Writes .ply (binary little endian) or .obj. Both keep all bits of a double. If
/// `material_texture` is given, an OBJ with UVs gets an .mtl file that names it.
/// @throws DiskError  cannot be written, disk full
void WriteMesh(const std::filesystem::path& path, const Mesh& mesh,
               const std::string& material_texture = "");

/// Writes many frames with the same faces as PLY files. Everything but the positions is prepared
/// once. The files are those that WriteMesh would write, without normals.
class PlyFrames {
 public:
  explicit PlyFrames(const Mesh& mesh);
  /// @pre as many points as the mesh has
  /// @throws DiskError
  void Write(const std::filesystem::path& path, const PointsX3& points);

 private:
  std::string bytes_;
  std::size_t vertices_at_ = 0, vertex_bytes_ = 0;
};

/// Reads PLY points, with nx ny nz, red green blue and confidence where present.
/// @throws as ReadMesh
PointCloud ReadPointCloud(const std::filesystem::path& path);
void WritePointCloud(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace keypose
