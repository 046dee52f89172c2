// Reads meshes and point clouds by content (PLY, OBJ, OFF, STL) and writes them by file name.
#pragma once

#include <filesystem>
#include <string>

#include "core/mesh.h"

namespace keypose {

/// A triangle mesh; polygons are fanned. Vertices and faces keep the order of the file (STL:
/// corners are welded where bit-equal). Reads positions, vertex normals, vertex colours and texture
/// coordinates (OBJ vt; PLY face property `texcoord`).
/// @throws DiskError   cannot be opened
/// @throws InputError  not one of the formats, truncated, an index out of range; says where
Mesh ReadMesh(const std::filesystem::path& path);

/// Writes .ply (binary little endian) or .obj; doubles keep all their bits in PLY; reading an OBJ
/// again may lose the last two. An OBJ with UVs names `material_texture` in an .mtl beside it when
/// that is given.
/// @throws DiskError  cannot be written, disk full
void WriteMesh(const std::filesystem::path& path, const Mesh& mesh,
               const std::string& material_texture = "");

/// Writes many frames of one connectivity as PLY: everything but the positions is made once. The
/// bytes are those of WriteMesh.
class PlyFrames {
 public:
  explicit PlyFrames(const Mesh& mesh);
  /// @pre as many points as the mesh @throws DiskError
  void Write(const std::filesystem::path& path, const PointsX3& points);

 private:
  std::string bytes_;
  std::size_t vertices_at_ = 0, vertex_bytes_ = 0;
};

/// PLY points with nx ny nz, red green blue and confidence where present.
/// @throws as ReadMesh
PointCloud ReadPointCloud(const std::filesystem::path& path);
void WritePointCloud(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace keypose
