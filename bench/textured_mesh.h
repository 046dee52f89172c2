// A mesh with its colours as programs write them: an OBJ whose materials name one or several
// texture pages, one page given apart, or colours at the vertices.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/mesh.h"

namespace keypose::bench {

struct TexturedMesh {
  Mesh mesh;
  /// RGB; none when the colours are at the vertices, or when there are none
  std::vector<Image8> pages;
  std::vector<int> page_of_face;  ///< F indices into pages, or empty without pages

  bool colored() const { return !pages.empty() || mesh.colors.rows() > 0; }
  /// sRGB 0..255 at barycentric (1-u-v, u, v) of a face. @pre colored()
  Eigen::Vector3d ColorAt(int face, double u, double v) const;
};

/// Pages come from `texture` when it is given, else from the `mtllib` and `usemtl` lines of an OBJ;
/// MTL options before a file's name are not understood.
/// @throws InputError  a texture for a mesh without UVs, a face with UVs whose material has no
/// page, a material that the MTL lacks
/// @throws DiskError   a file cannot be opened
TexturedMesh ReadTexturedMesh(const std::filesystem::path& mesh,
                              const std::filesystem::path& texture = {});

}  // namespace keypose::bench
