// Several textures of one mesh ("pages"), baked into one layout and one texture. Also what one
// texture needs before it is one: repeats, mirrored repeats, factors, WebP.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// What lies beyond the unit square of a texture.
enum class Wrap { kRepeat, kMirror, kClamp };

/// A picture as a material shows it.
struct TexturePage {
  int picture = 0;  ///< index into the pictures
  Wrap wrap_u = Wrap::kRepeat, wrap_v = Wrap::kRepeat;
  Eigen::Vector3d factor = Eigen::Vector3d::Ones();  ///< linear light; multiplies the picture
  bool operator==(const TexturePage&) const = default;
};

/// A picture file.
struct PageFile {
  std::string name;   ///< for messages
  std::string bytes;  ///< the file itself
};

/// A triangle mesh whose faces show pages.
struct PagedMesh {
  Mesh mesh;  ///< with uvs and uv_faces where there is a page
  std::vector<PageFile> pictures;
  std::vector<TexturePage> pages;  ///< each has faces
  std::vector<int> page_of_face;   ///< F; -1: the face has the colours of its corners
  /// F, or empty where no face is of page -1: colours of the corners, in linear light
  std::vector<std::array<Eigen::Vector3d, 3>> corner_colors;

  /// Finds a page, or adds it.
  int PageOf(const TexturePage& page);
};

/// One texture in the place of all pages. `uvs` and `uv_faces` are those of the mesh in the new
/// layout.
struct OneTexture {
  UvsX2 uvs;
  FacesX3 uv_faces;
  std::string picture;     ///< PNG, JPEG, TIFF or HEIC; empty: it cannot be made
  std::string ending;      ///< ".png" and so on
  bool as_it_was = false;  ///< the picture and the coordinates are those of the input
  std::string why;         ///< a sentence for a warning; empty: nothing to tell
};

/// Bakes all pages into one. A single picture whose coordinates lie in the unit square, or can be
/// shifted there by whole repeats, stays the file that it is; a WebP becomes a PNG. Texels are
/// copied, not resampled, as long as all fit into 16384 x 16384; else all pages shrink, and `why`
/// says so.
/// @pre there is a page
/// @param paged  its pictures and coordinates are moved out where they stay as they are
/// @param who    the mesh's name, for messages
OneTexture JoinPages(PagedMesh&& paged, const std::string& who);

}  // namespace keypose
