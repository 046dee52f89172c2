// A mesh with its colours in the forms that programs write: an OBJ whose materials name one or
// several texture pages, a separate page, or vertex colours.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::bench {

struct TexturedMesh {
  Mesh mesh;
  /// RGB; none if the mesh has vertex colours or no colours
  std::vector<Image8> pages;
  std::vector<int> page_of_face;  ///< F indices into pages; empty without pages

  bool colored() const { return !pages.empty() || mesh.colors.rows() > 0; }
  /// sRGB 0..255 at barycentric (1-u-v, u, v) of a face. @pre colored()
  Eigen::Vector3d ColorAt(int face, double u, double v) const;
};

/// Pages come from `texture` if it is given, else from the `mtllib` and `usemtl` lines of an OBJ.
/// MTL options before a file's name are not supported.
/// @throws InputError  a texture for a mesh without UVs, a face with UVs whose material has no
/// page, a material missing from the MTL
/// @throws DiskError   a file cannot be opened
TexturedMesh ReadTexturedMesh(const std::filesystem::path& mesh,
                              const std::filesystem::path& texture = {});

}  // namespace keypose::bench
