// A glTF 2.0 file as it is written: the container (.glb, or .gltf with files beside it), and the
// parts of its JSON that matter to the surface and its colours. What the numbers mean is in
// gltf_data.h, gltf_look.h and glb_mesh.h. The JSON library stays in the .cpp.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/meshes/texture_pages.h"

namespace keypose {

// Indices are -1 where the file names none. They are not checked: GltfFile::At does that.

struct GltfBuffer {
  std::string own;         ///< bytes of a data URI or another file
  std::string_view bytes;  ///< all that there is; empty: the buffer is a place holder
};

/// EXT_meshopt_compression of a view.
struct GltfPacked {
  int buffer = -1;
  std::size_t offset = 0, length = 0, stride = 0, count = 0;
  std::string mode, filter;
};

struct GltfView {
  int buffer = -1;
  std::size_t offset = 0, length = 0, stride = 0;  ///< stride 0: elements lie side by side
  std::optional<GltfPacked> packed;
};

struct GltfSparse {
  std::size_t count = 0;
  int index_view = -1, index_component = 0, value_view = -1;
  std::size_t index_offset = 0, value_offset = 0;
};

struct GltfAccessor {
  int view = -1;
  std::size_t offset = 0, count = 0;
  int component = 0;  ///< 5120 to 5126, 5130
  int columns = 0;    ///< 1 of SCALAR, 16 of MAT4
  bool normalized = false;
  std::optional<GltfSparse> sparse;
};

using GltfAttributes = std::map<std::string, int>;

struct GltfPrimitive {
  GltfAttributes attributes;
  int indices = -1, material = -1, mode = 4;
  std::vector<GltfAttributes> targets;
  int draco_view = -1;              ///< KHR_draco_mesh_compression
  GltfAttributes draco_attributes;  ///< its unique ids
  bool splats = false;              ///< KHR_gaussian_splatting
};

struct GltfMesh {
  std::vector<GltfPrimitive> primitives;
  std::vector<double> weights;
};

struct GltfNode {
  Eigen::Affine3d parent_from_node = Eigen::Affine3d::Identity();
  int mesh = -1, skin = -1;
  std::vector<int> children;
  std::vector<double> weights;
  bool visible = true;       ///< KHR_node_visibility
  GltfAttributes instances;  ///< EXT_mesh_gpu_instancing
};

struct GltfSkin {
  std::vector<int> joints;
  int inverse_bind = -1;
};

/// A texture as a material takes it.
struct GltfTextureInfo {
  int texture = -1, uv_set = 0;
  /// KHR_texture_transform, in glTF's coordinates (v down)
  Eigen::Affine2d transform = Eigen::Affine2d::Identity();
};

struct GltfMaterial {
  GltfTextureInfo color;
  Eigen::Vector3d factor = Eigen::Vector3d::Ones();  ///< linear light
};

struct GltfTexture {
  int image = -1;  ///< of glTF itself
  std::map<std::string, int> images_of_extensions;
  Wrap wrap_u = Wrap::kRepeat, wrap_v = Wrap::kRepeat;
};

struct GltfImage {
  int view = -1;
  std::string name;
  std::string bytes;  ///< of a URI
  std::string why;    ///< what keeps the URI from being read
};

class GltfFile {
 public:
  /// @throws DiskError   the file cannot be read
  /// @throws InputError  it is no glTF 2.0, is damaged, names files outside of its folder, or needs
  ///                     an extension that is not read
  explicit GltfFile(const std::filesystem::path& path);
  GltfFile(const GltfFile&) = delete;
  GltfFile& operator=(const GltfFile&) = delete;

  std::vector<GltfBuffer> buffers;
  std::vector<GltfView> views;
  std::vector<GltfAccessor> accessors;
  std::vector<GltfMesh> meshes;
  std::vector<GltfNode> nodes;
  std::vector<GltfSkin> skins;
  std::vector<GltfMaterial> materials;
  std::vector<GltfTexture> textures;
  std::vector<GltfImage> images;
  std::vector<int> roots;                            ///< nodes of the scene that is shown
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< CESIUM_RTC: where the scene's origin lies
  std::set<std::string> required;                    ///< extensions that the file needs
  std::vector<std::string> warnings;

  const std::string& name() const { return name_; }
  std::size_t bytes() const { return bytes_.size(); }

  /// @throws InputError  always; says what to do
  [[noreturn]] void Refuse(const std::string& why) const;
  /// An entry of a list, by an index from the file. @throws InputError  there is none
  template <class T>
  const T& At(const std::vector<T>& list, int index, const char* what) const {
    if (index < 0 || index >= static_cast<int>(list.size()))
      Refuse(std::string("it is damaged (a ") + what + " that does not exist)");
    return list[static_cast<std::size_t>(index)];
  }

 private:
  std::string name_, bytes_;
};

/// Whether a file begins as a glTF does, binary or JSON.
/// @param head  its first 4096 bytes
bool LooksLikeGltf(std::string_view head);

}  // namespace keypose
