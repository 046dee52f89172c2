// Frames as PLY files that leave Keypose.
#pragma once

#include <filesystem>
#include <string>

#include "core/values/mesh.h"

namespace keypose {

/// As PlyFrames of mesh_io.h, but with texture coordinates in single precision: MeshLab knows lists
/// of no other type and leaves the texture out. Between stages they stay double, so that equal ones
/// are found again.
class PlyFramesForOthers {
 public:
  explicit PlyFramesForOthers(const Mesh& mesh);
  /// @pre as many points as the mesh has
  /// @throws DiskError
  void Write(const std::filesystem::path& path, const PointsX3& points);

 private:
  std::string bytes_;
  std::size_t vertices_at_ = 0, vertex_bytes_ = 0;
};

}  // namespace keypose
