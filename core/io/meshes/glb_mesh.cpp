#include "core/io/meshes/glb_mesh.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "core/io/text/files.h"
#include "core/pictures/srgb.h"
#include "core/surfaces/seams.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;
using tinygltf::Model;

constexpr int kMostNodes = 100000;  // that are placed; one that contains itself would have no end
constexpr std::size_t kMostPoints = 50'000'000;

/// Keeps a picture as it is stored in the text. The library does not check where in the data one
/// lies, so that those are read by PictureBytes.
bool KeepBytes(tinygltf::Image* image, const int, std::string*, std::string*, int, int,
               const unsigned char* bytes, int size, void*) {
  if (image->bufferView < 0) image->image.assign(bytes, bytes + size);
  return true;
}

/// What a GLB names outside of itself is not opened.
tinygltf::FsCallbacks NoFiles() {
  tinygltf::FsCallbacks none{};
  none.FileExists = [](const std::string&, void*) { return false; };
  none.ExpandFilePath = [](const std::string& name, void*) { return name; };
  none.ReadWholeFile = [](std::vector<unsigned char>*, std::string* error, const std::string& name,
                          void*) {
    *error += name + " lies outside of the file; ";
    return false;
  };
  none.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&,
                           void*) { return false; };
  return none;
}

/// Numbers of an accessor, one row each.
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class GlbReader {
 public:
  GlbReader(const fs::path& path, bool join) : name_(PrintableName(path)), join_(join) {
    const std::string bytes = ReadFile(path);
    if (!bytes.starts_with("glTF")) Refuse("it is no binary glTF");
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(KeepBytes, nullptr);
    loader.SetFsCallbacks(NoFiles());
    std::string error, warning;
    if (bytes.size() > std::numeric_limits<unsigned>::max() ||
        !loader.LoadBinaryFromMemory(&model_, &error, &warning,
                                     reinterpret_cast<const unsigned char*>(bytes.data()),
                                     static_cast<unsigned>(bytes.size())))
      Refuse(error.substr(0, error.find('\n')));
    RequireExtensions();
  }

  GlbMesh Read() {
    for (const int root : Roots()) Place(root, Eigen::Affine3d::Identity());
    if (faces_.empty()) Refuse("it has no triangles");
    GlbMesh result;
    FindTexture(&result);
    result.mesh = Joined(!result.texture.empty());
    if (skipped_ > 0)
      result.warnings.push_back(
          fmt::format("{}: {} of its parts are lines, points, strips or fans, and were left out",
                      name_, skipped_));
    return result;
  }

 private:
  [[noreturn]] void Refuse(const std::string& why) const {
    throw InputError(
        fmt::format("{} cannot be read: {}; open it in Blender and export it as OBJ", name_, why));
  }

  void RequireExtensions() const {
    const std::set<std::string> harmless = {"KHR_mesh_quantization", "KHR_materials_unlit",
                                            "KHR_texture_transform"};
    for (const std::string& extension : model_.extensionsRequired)
      if (!harmless.contains(extension))
        Refuse(
            fmt::format("it needs the extension {}; export it without compression (Draco, "
                        "meshopt) and the like",
                        extension));
  }

  template <class T>
  const T& At(const std::vector<T>& list, int index, const char* what) const {
    if (index < 0 || index >= SizeOf(list))
      Refuse(fmt::format("it is damaged (a {} that does not exist)", what));
    return list[index];
  }

  std::vector<int> Roots() const {
    if (!model_.scenes.empty())
      return At(model_.scenes, std::max(0, model_.defaultScene), "scene").nodes;
    std::vector<char> child(model_.nodes.size(), 0);
    for (const tinygltf::Node& node : model_.nodes)
      for (const int c : node.children) {
        At(model_.nodes, c, "node");
        child[c] = 1;
      }
    std::vector<int> roots;
    for (int i = 0; i < SizeOf(child); ++i)
      if (!child[i]) roots.push_back(i);
    return roots;
  }

  static Eigen::Affine3d PlaceOf(const tinygltf::Node& node) {
    Eigen::Affine3d place = Eigen::Affine3d::Identity();
    if (node.matrix.size() == 16) {
      place.matrix() = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
      return place;
    }
    if (node.translation.size() == 3)
      place.translate(Eigen::Map<const Eigen::Vector3d>(node.translation.data()));
    if (node.rotation.size() == 4)
      place.rotate(
          Eigen::Quaterniond(Eigen::Map<const Eigen::Vector4d>(node.rotation.data())).normalized());
    if (node.scale.size() == 3) place.scale(Eigen::Map<const Eigen::Vector3d>(node.scale.data()));
    return place;
  }

  void Place(int index, const Eigen::Affine3d& parent, int depth = 0) {
    constexpr int kDeepest = 1000;
    if (++placed_ > kMostNodes || depth > kDeepest)
      Refuse("it is damaged (nodes that contain each other)");
    const tinygltf::Node& node = At(model_.nodes, index, "node");
    const Eigen::Affine3d place = parent * PlaceOf(node);
    if (node.mesh >= 0)
      for (const tinygltf::Primitive& part : At(model_.meshes, node.mesh, "mesh").primitives)
        AddPart(part, place);
    for (const int child : node.children) Place(child, place, depth + 1);
  }

  const unsigned char* Element(const tinygltf::Accessor& accessor, std::size_t* stride,
                               std::size_t size) const {
    if (accessor.sparse.isSparse || accessor.bufferView < 0)
      Refuse("it has sparse data; export it without");
    const auto& view = At(model_.bufferViews, accessor.bufferView, "part of its data");
    const auto& buffer = At(model_.buffers, view.buffer, "part of its data").data;
    *stride = view.byteStride > 0 ? view.byteStride : size;
    const std::size_t last = accessor.count > 0 ? accessor.count - 1 : 0;
    if (view.byteOffset > buffer.size() || view.byteLength > buffer.size() - view.byteOffset ||
        accessor.byteOffset > view.byteLength || size > view.byteLength - accessor.byteOffset ||
        (*stride > 0 && last > (view.byteLength - accessor.byteOffset - size) / *stride))
      Refuse("it is damaged (data that it does not have)");
    return buffer.data() + view.byteOffset + accessor.byteOffset;
  }

  template <class T>
  Rows Converted(const tinygltf::Accessor& accessor, int columns) const {
    std::size_t stride = 0;
    if (accessor.count == 0) return Rows(0, columns);
    const unsigned char* from = Element(accessor, &stride, columns * sizeof(T));
    Rows rows(static_cast<Eigen::Index>(accessor.count), columns);  // no more than the file has
    const double scale =
        accessor.normalized ? 1.0 / static_cast<double>(std::numeric_limits<T>::max()) : 1.0;
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
      for (int c = 0; c < columns; ++c) {
        T value;
        std::memcpy(&value, from + i * stride + c * sizeof(T), sizeof(T));
        rows(i, c) = scale * static_cast<double>(value);
      }
    return rows;
  }

  Rows Numbers(int index) const {
    const tinygltf::Accessor& accessor = At(model_.accessors, index, "list of numbers");
    const int columns = tinygltf::GetNumComponentsInType(accessor.type);
    if (columns < 1) Refuse("it is damaged (numbers of an unknown kind)");
    switch (accessor.componentType) {
      case TINYGLTF_COMPONENT_TYPE_BYTE:
        return Converted<std::int8_t>(accessor, columns);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return Converted<std::uint8_t>(accessor, columns);
      case TINYGLTF_COMPONENT_TYPE_SHORT:
        return Converted<std::int16_t>(accessor, columns);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return Converted<std::uint16_t>(accessor, columns);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return Converted<std::uint32_t>(accessor, columns);
      case TINYGLTF_COMPONENT_TYPE_FLOAT: {
        tinygltf::Accessor plain = accessor;
        plain.normalized = false;
        return Converted<float>(plain, columns);
      }
      default:
        Refuse("it is damaged (numbers of an unknown kind)");
    }
  }

  /// Empty: the part has none.
  Rows Attribute(const tinygltf::Primitive& part, const std::string& name, int columns) const {
    const auto it = part.attributes.find(name);
    if (it == part.attributes.end()) return {};
    Rows rows = Numbers(it->second);
    if (rows.cols() < columns) Refuse(fmt::format("it is damaged ({})", name));
    return rows;
  }

  void AddPart(const tinygltf::Primitive& part, const Eigen::Affine3d& place) {
    if (part.mode != TINYGLTF_MODE_TRIANGLES && part.mode != -1) {
      ++skipped_;
      return;
    }
    const Rows points = Attribute(part, "POSITION", 3);
    if (points_.size() + points.rows() > kMostPoints) Refuse("it has too many vertices");
    const int first = SizeOf(points_);
    const Look look = LookOf(part);
    const Rows uvs = Attribute(part, "TEXCOORD_" + std::to_string(look.uv_set), 2),
               colors = Attribute(part, "COLOR_0", 3);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const Eigen::Vector3d p = place * Eigen::Vector3d(points.row(i).head<3>());
      if (!p.allFinite()) Refuse("it has a vertex that is not finite");
      points_.emplace_back(p.x(), -p.z(), p.y());  // y up becomes z up
      const bool has_uv = i < uvs.rows();
      uvs_.emplace_back(has_uv ? uvs(i, 0) : 0, has_uv ? 1 - uvs(i, 1) : 0);
      Eigen::Vector3d color = look.factor;
      if (i < colors.rows()) color.array() *= colors.row(i).head<3>().transpose().array();
      colors_.push_back(color);
    }
    has_colors_ |= colors.rows() > 0 || look.factor != Eigen::Vector3d::Ones();
    AddFaces(part, first, static_cast<int>(points.rows()), place.linear().determinant() < 0);
    images_.insert(uvs.rows() > 0 ? look.image : -1);
  }

  void AddFaces(const tinygltf::Primitive& part, int first, int count, bool mirrored) {
    Rows corners;
    if (part.indices >= 0) {
      corners = Numbers(part.indices);
    } else {
      corners = Rows(count, 1);
      for (int i = 0; i < count; ++i) corners(i, 0) = i;
    }
    for (Eigen::Index i = 0; i + 2 < corners.rows(); i += 3) {
      Eigen::Vector3i face;
      for (int k = 0; k < 3; ++k) {
        if (corners(i + k, 0) < 0 || corners(i + k, 0) >= count)
          Refuse("it is damaged (a corner that does not exist)");
        face[k] = first + static_cast<int>(corners(i + k, 0));
      }
      if (mirrored) std::swap(face[1], face[2]);
      if (face[0] != face[1] && face[1] != face[2] && face[0] != face[2]) faces_.push_back(face);
    }
  }

  struct Look {
    int image = -1, uv_set = 0;
    Eigen::Vector3d factor = Eigen::Vector3d::Ones();  // linear light
  };
  Look LookOf(const tinygltf::Primitive& part) const {
    Look look;
    if (part.material < 0) return look;
    const auto& colour = At(model_.materials, part.material, "material").pbrMetallicRoughness;
    if (colour.baseColorFactor.size() >= 3)
      look.factor = Eigen::Map<const Eigen::Vector3d>(colour.baseColorFactor.data());
    if (colour.baseColorTexture.index < 0) return look;
    look.image = At(model_.textures, colour.baseColorTexture.index, "texture").source;
    look.uv_set = std::clamp(colour.baseColorTexture.texCoord, 0, 7);
    return look;
  }

  void FindTexture(GlbMesh* result) const {
    std::set<int> images = images_;
    const bool bare = images.erase(-1) > 0;
    if (images.empty()) return;
    const auto warn = [&](const std::string& what) {
      result->warnings.push_back(fmt::format("{}: {}", name_, what));
    };
    if (images.size() > 1)
      return warn(fmt::format(
          "it has {} textures, but one is used: bake them into one layout and one texture in your "
          "scanning or modelling program first",
          images.size()));
    const std::string text = PictureBytes(At(model_.images, *images.begin(), "picture"));
    result->texture_ending.clear();
    if (text.starts_with("\x89PNG")) result->texture_ending = ".png";
    if (text.starts_with("\xff\xd8\xff")) result->texture_ending = ".jpg";
    if (result->texture_ending.empty())
      return warn("its texture is neither PNG nor JPEG, so that it cannot be used");
    result->texture = text;
    if (bare) warn("some of its parts have no texture: they will have a colour of it");
  }

  std::string PictureBytes(const tinygltf::Image& image) const {
    if (image.bufferView < 0) return {image.image.begin(), image.image.end()};
    const auto& view = At(model_.bufferViews, image.bufferView, "part of its data");
    const auto& buffer = At(model_.buffers, view.buffer, "part of its data").data;
    if (view.byteOffset > buffer.size() || view.byteLength > buffer.size() - view.byteOffset)
      Refuse("it is damaged (data that it does not have)");
    return {reinterpret_cast<const char*>(buffer.data()) + view.byteOffset, view.byteLength};
  }

  Mesh Joined(bool with_uvs) const {
    Mesh flat;
    flat.points.resize(SizeOf(points_), 3);
    flat.faces.resize(SizeOf(faces_), 3);
    for (int i = 0; i < SizeOf(points_); ++i) flat.points.row(i) = points_[i].transpose();
    for (int f = 0; f < SizeOf(faces_); ++f) flat.faces.row(f) = faces_[f].transpose();
    WeldedMesh welded = join_ ? WeldWholeFaces(flat) : Weld(flat, {});
    Mesh mesh = std::move(welded.mesh);
    if (with_uvs) {
      mesh.uv_faces = flat.faces;
      mesh.uvs.resize(SizeOf(uvs_), 2);
      for (int i = 0; i < SizeOf(uvs_); ++i) mesh.uvs.row(i) = uvs_[i].transpose();
    } else if (has_colors_) {
      mesh.colors.resize(mesh.points.rows(), 3);
      for (int i = SizeOf(points_) - 1; i >= 0; --i)
        for (int c = 0; c < 3; ++c)
          mesh.colors(welded.of_input[i], c) = static_cast<std::uint8_t>(
              std::lround(255 * SrgbFromLinear(std::clamp(colors_[i][c], 0.0, 1.0))));
    }
    return mesh;
  }

  std::string name_;
  Model model_;
  std::vector<Eigen::Vector3d> points_, colors_;
  std::vector<Eigen::Vector2d> uvs_;
  std::vector<Eigen::Vector3i> faces_;
  std::set<int> images_;  ///< of the parts; -1: one without a texture
  bool join_ = true, has_colors_ = false;
  int placed_ = 0, skipped_ = 0;
};

}  // namespace

GlbMesh ReadGlb(const fs::path& path, bool join_seams) {
  return GlbReader(path, join_seams).Read();
}

}  // namespace keypose
