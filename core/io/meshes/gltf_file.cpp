#include "core/io/meshes/gltf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/io/meshes/beside.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

/// Extensions that a file may need: they are read, or change neither the shape nor the colour.
const std::set<std::string>& KnownExtensions() {
  static const std::set<std::string> known = {
      // read
      "KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression",
      "KHR_mesh_quantization", "KHR_texture_transform", "KHR_materials_unlit",
      "KHR_materials_pbrSpecularGlossiness", "EXT_texture_webp", "EXT_mesh_gpu_instancing",
      "KHR_node_visibility", "CESIUM_RTC", "KHR_accessor_float64",
      // colour of light, gloss, clear coats; names and numbers for programs
      "KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_dispersion",
      "KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_iridescence",
      "KHR_materials_sheen", "KHR_materials_specular", "KHR_materials_transmission",
      "KHR_materials_variants", "KHR_materials_volume", "KHR_materials_diffuse_transmission",
      "KHR_lights_punctual", "EXT_lights_image_based", "EXT_lights_ies", "KHR_animation_pointer",
      "KHR_xmp", "KHR_xmp_json_ld", "KHR_node_hoverability", "KHR_node_selectability",
      "KHR_interactivity", "KHR_audio_emitter", "EXT_mesh_features", "EXT_instance_features",
      "EXT_structural_metadata", "EXT_mesh_manifold", "FB_ngon_encoding", "MSFT_lod",
      "MSFT_packing_normalRoughnessMetallic", "MSFT_packing_occlusionRoughnessMetallic",
      "AGI_articulations", "AGI_stk_metadata", "CESIUM_primitive_outline", "GRIFFEL_bim_data",
      "NV_materials_mdl", "ADOBE_materials_thin_transparency", "ADOBE_materials_clearcoat_tint"};
  return known;
}

/// Textures of other kinds are looked at where a material needs one: it may have a second source.
bool IsTextureExtension(const std::string& name) {
  return name == "KHR_texture_basisu" || name == "MSFT_texture_dds" || name == "EXT_texture_avif" ||
         name == "KHR_texture_float";
}

std::uint32_t Word(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, 4);
  return value;
}

class GltfParser {
 public:
  GltfParser(GltfFile* file, const fs::path& path, std::string_view bytes)
      : file_(*file), path_(path), bytes_(bytes) {}

  void Parse() {
    FindChunks();
    while (json_text_.ends_with('\0')) json_text_.remove_suffix(1);  // wrong, but seen
    if (!IsShallowJson(json_text_)) file_.Refuse("it is damaged (its JSON is nested too deeply)");
    const Json root = Json::parse(json_text_.begin(), json_text_.end(), nullptr, false);
    if (!root.is_object()) file_.Refuse("it is damaged (its JSON is not whole)");
    try {
      TakeAll(root);
    } catch (const Json::exception& error) {
      file_.Refuse(fmt::format("it is damaged ({})", JsonFault(error)));
    }
  }

 private:
  void FindChunks() {
    if (!bytes_.starts_with("glTF")) {
      json_text_ = bytes_;
      if (json_text_.starts_with("\xef\xbb\xbf")) json_text_.remove_prefix(3);
      return;
    }
    if (bytes_.size() < 20) file_.Refuse("it is no whole binary glTF");
    if (Word(bytes_, 4) != 2)
      file_.Refuse(
          fmt::format("it is a binary glTF of version {}, and 2 is read", Word(bytes_, 4)));
    if (Word(bytes_, 8) > bytes_.size())
      file_.Refuse(fmt::format("it has {} of {} bytes: it is no whole binary glTF", bytes_.size(),
                               Word(bytes_, 8)));
    const std::string_view all = bytes_.substr(0, Word(bytes_, 8));
    for (std::size_t at = 12; at + 8 <= all.size();) {
      const std::size_t length = Word(all, at);
      if (length > all.size() - at - 8) file_.Refuse("it is damaged (a chunk beyond its end)");
      const std::string_view chunk = all.substr(at + 8, length);
      if (Word(all, at + 4) == kJsonChunk && json_text_.empty()) json_text_ = chunk;
      if (Word(all, at + 4) == kBinaryChunk && !binary_) binary_ = chunk;
      at += 8 + length;
    }
  }

  void TakeAll(const Json& root) {
    RequireVersion(root);
    RequireExtensions(root);
    for (const Json& json : ListOf(root, "buffers")) TakeBuffer(json);
    for (const Json& json : ListOf(root, "bufferViews")) TakeView(json);
    for (const Json& json : ListOf(root, "accessors")) TakeAccessor(json);
    for (const Json& json : ListOf(root, "meshes")) TakeMesh(json);
    for (const Json& json : ListOf(root, "nodes")) TakeNode(json);
    for (const Json& json : ListOf(root, "skins")) TakeSkin(json);
    for (const Json& json : ListOf(root, "materials")) TakeMaterial(json);
    for (const Json& json : ListOf(root, "samplers")) TakeSampler(json);
    for (const Json& json : ListOf(root, "textures")) TakeTexture(json);
    for (const Json& json : ListOf(root, "images")) TakeImage(json);
    TakeScene(root);
    const Json& rtc = ExtensionOf(root, "CESIUM_RTC");
    if (rtc.is_object()) file_.center = VectorOf<3>(rtc, "center", Eigen::Vector3d::Zero());
  }

  // --- JSON ---

  static const Json& ListOf(const Json& json, const char* key) {
    static const Json empty = Json::array();
    const auto it = json.find(key);
    return it == json.end() || it->is_null() ? empty : *it;
  }

  /// Null: there is none.
  static const Json& ExtensionOf(const Json& json, const char* name) {
    static const Json none;
    const auto all = json.find("extensions");
    if (all == json.end() || !all->is_object()) return none;
    const auto it = all->find(name);
    return it == all->end() ? none : *it;
  }

  static bool Has(const Json& json, const char* key) { return json.find(key) != json.end(); }

  std::size_t SizeAt(const Json& json, const char* key, std::size_t otherwise = 0) const {
    const auto it = json.find(key);
    if (it == json.end()) return otherwise;
    constexpr double kMost = 9e15;  // that a double still counts
    const double value = it->get<double>();
    if (!(value >= 0 && value <= kMost) || value != std::floor(value))
      file_.Refuse(fmt::format("it is damaged ({} is no count)", key));
    return static_cast<std::size_t>(value);
  }

  int IndexAt(const Json& json, const char* key, int otherwise = -1) const {
    return Has(json, key) ? Small(SizeAt(json, key), key) : otherwise;
  }

  int Small(std::size_t value, const char* key) const {
    if (value > static_cast<std::size_t>(std::numeric_limits<int>::max()))
      file_.Refuse(fmt::format("it is damaged ({} is too large)", key));
    return static_cast<int>(value);
  }

  std::vector<int> IndicesAt(const Json& json, const char* key) const {
    std::vector<int> indices;
    for (const Json& entry : ListOf(json, key)) {
      const Json holder = {{"index", entry}};
      indices.push_back(IndexAt(holder, "index"));
    }
    return indices;
  }

  static std::vector<double> NumbersAt(const Json& json, const char* key) {
    std::vector<double> numbers;
    for (const Json& entry : ListOf(json, key)) numbers.push_back(entry.get<double>());
    return numbers;
  }

  template <int N>
  Eigen::Matrix<double, N, 1> VectorOf(const Json& json, const char* key,
                                       const Eigen::Matrix<double, N, 1>& otherwise) const {
    if (!Has(json, key)) return otherwise;
    const std::vector<double> numbers = NumbersAt(json, key);
    // A colour's alpha may follow.
    if (std::ssize(numbers) < N) file_.Refuse(fmt::format("it is damaged ({} is too short)", key));
    return Eigen::Map<const Eigen::Matrix<double, N, 1>>(numbers.data());
  }

  GltfAttributes AttributesAt(const Json& json, const char* key) const {
    GltfAttributes attributes;
    const auto it = json.find(key);
    if (it == json.end()) return attributes;
    for (const auto& [name, value] : it->items()) {
      const Json holder = {{"index", value}};
      attributes[name] = IndexAt(holder, "index");
    }
    return attributes;
  }

  // --- parts ---

  void RequireVersion(const Json& root) const {
    const auto asset = root.find("asset");
    const std::string version = asset == root.end() ? "" : asset->value("version", std::string());
    if (!version.starts_with("2."))
      file_.Refuse(version.empty()
                       ? "it is no glTF (it names no version)"
                       : fmt::format("it is glTF {}, and 2.0 is read", WithoutOddBytes(version)));
    const std::string least = asset->value("minVersion", std::string("2.0"));
    if (least != "2.0")
      file_.Refuse(fmt::format("it needs a reader of glTF {} (minVersion), and 2.0 is read",
                               WithoutOddBytes(least)));
  }

  void RequireExtensions(const Json& root) {
    for (const Json& entry : ListOf(root, "extensionsRequired")) {
      const std::string name = entry.get<std::string>();
      file_.required.insert(name);
      if (!KnownExtensions().contains(name) && !IsTextureExtension(name))
        file_.Refuse(
            fmt::format("it needs the extension {}, which is not read", WithoutOddBytes(name)));
    }
  }

  /// The bytes that a URI names. Files must lie in the mesh's folder or below.
  /// @param why  what keeps them from being read
  std::optional<std::string> BytesOfUri(const std::string& uri, std::string* why) const {
    if (uri.starts_with("data:")) return BytesOfDataUri(uri, why);
    const std::string name = WithoutPercents(uri);
    const fs::path found = FileBeside(path_, name);
    if (!found.empty()) return ReadFile(found);
    *why = fmt::format("it names the file {}, which is not beside it: copy its whole folder",
                       PrintableName(name));
    return std::nullopt;
  }

  static std::optional<std::string> BytesOfDataUri(const std::string& uri, std::string* why) {
    const std::size_t comma = uri.find(',');
    if (comma == uri.npos || uri.substr(0, comma).find(";base64") == uri.npos) {
      *why = "it is damaged (a data URI that is not base64)";
      return std::nullopt;
    }
    return FromBase64(std::string_view(uri).substr(comma + 1));
  }

  static std::string FromBase64(std::string_view text) {
    std::string bytes;
    bytes.reserve(text.size() * 3 / 4);
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
      const int value = Base64Digit(c);
      if (value < 0) continue;  // padding and line ends
      bits = bits << 6 | static_cast<std::uint32_t>(value);
      count += 6;
      if (count < 8) continue;
      count -= 8;
      bytes.push_back(static_cast<char>(bits >> count & 0xff));
    }
    return bytes;
  }

  static int Base64Digit(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+' || c == '-') return 62;
    return c == '/' || c == '_' ? 63 : -1;
  }

  void TakeBuffer(const Json& json) {
    GltfBuffer buffer;
    const bool first = file_.buffers.empty();
    if (Has(json, "uri")) {
      std::string why;
      auto bytes = BytesOfUri(json.at("uri").get<std::string>(), &why);
      if (!bytes) file_.Refuse(why);
      buffer.own = std::move(*bytes);
    }
    file_.buffers.push_back(std::move(buffer));
    GltfBuffer& kept = file_.buffers.back();
    if (Has(json, "uri"))
      own_.push_back(file_.buffers.size() - 1);
    else if (first && binary_)
      kept.bytes = *binary_;
  }

  void TakeView(const Json& json) {
    GltfView view;
    view.buffer = IndexAt(json, "buffer");
    view.offset = SizeAt(json, "byteOffset");
    view.length = SizeAt(json, "byteLength");
    view.stride = SizeAt(json, "byteStride");
    for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
      const Json& packed = ExtensionOf(json, name);
      if (!packed.is_object()) continue;
      view.packed = GltfPacked{IndexAt(packed, "buffer"),
                               SizeAt(packed, "byteOffset"),
                               SizeAt(packed, "byteLength"),
                               SizeAt(packed, "byteStride"),
                               SizeAt(packed, "count"),
                               packed.value("mode", std::string()),
                               packed.value("filter", std::string("NONE"))};
    }
    file_.views.push_back(view);
  }

  static int ColumnsOf(const std::string& type) {
    constexpr std::array<std::pair<const char*, int>, 7> kTypes = {{{"SCALAR", 1},
                                                                    {"VEC2", 2},
                                                                    {"VEC3", 3},
                                                                    {"VEC4", 4},
                                                                    {"MAT2", 4},
                                                                    {"MAT3", 9},
                                                                    {"MAT4", 16}}};
    for (const auto& [name, columns] : kTypes)
      if (type == name) return columns;
    return 0;
  }

  void TakeAccessor(const Json& json) {
    GltfAccessor accessor;
    accessor.view = IndexAt(json, "bufferView");
    accessor.offset = SizeAt(json, "byteOffset");
    accessor.count = SizeAt(json, "count");
    accessor.component = IndexAt(json, "componentType");
    accessor.columns = ColumnsOf(json.value("type", std::string()));
    accessor.normalized = json.value("normalized", false);
    if (Has(json, "sparse")) {
      const Json &sparse = json.at("sparse"), &indices = sparse.at("indices"),
                 &values = sparse.at("values");
      accessor.sparse =
          GltfSparse{SizeAt(sparse, "count"),           IndexAt(indices, "bufferView"),
                     IndexAt(indices, "componentType"), IndexAt(values, "bufferView"),
                     SizeAt(indices, "byteOffset"),     SizeAt(values, "byteOffset")};
    }
    file_.accessors.push_back(accessor);
  }

  void TakeMesh(const Json& json) {
    GltfMesh mesh;
    mesh.weights = NumbersAt(json, "weights");
    for (const Json& part : ListOf(json, "primitives")) mesh.primitives.push_back(PartOf(part));
    file_.meshes.push_back(std::move(mesh));
  }

  GltfPrimitive PartOf(const Json& json) const {
    GltfPrimitive part;
    part.attributes = AttributesAt(json, "attributes");
    part.indices = IndexAt(json, "indices");
    part.material = IndexAt(json, "material");
    part.mode = IndexAt(json, "mode", 4);
    for (const Json& target : ListOf(json, "targets")) {
      const Json holder = {{"target", target}};
      part.targets.push_back(AttributesAt(holder, "target"));
    }
    const Json& draco = ExtensionOf(json, "KHR_draco_mesh_compression");
    if (draco.is_object()) {
      part.draco_view = IndexAt(draco, "bufferView");
      part.draco_attributes = AttributesAt(draco, "attributes");
    }
    part.splats = ExtensionOf(json, "KHR_gaussian_splatting").is_object();
    return part;
  }

  void TakeNode(const Json& json) {
    GltfNode node;
    node.parent_from_node = PlaceOf(json);
    node.mesh = IndexAt(json, "mesh");
    node.skin = IndexAt(json, "skin");
    node.children = IndicesAt(json, "children");
    node.weights = NumbersAt(json, "weights");
    const Json& visibility = ExtensionOf(json, "KHR_node_visibility");
    if (visibility.is_object()) node.visible = visibility.value("visible", true);
    const Json& instances = ExtensionOf(json, "EXT_mesh_gpu_instancing");
    if (instances.is_object()) node.instances = AttributesAt(instances, "attributes");
    file_.nodes.push_back(std::move(node));
  }

  Eigen::Affine3d PlaceOf(const Json& json) const {
    Eigen::Affine3d place = Eigen::Affine3d::Identity();
    if (Has(json, "matrix")) {
      const Eigen::Matrix<double, 16, 1> numbers =
          VectorOf<16>(json, "matrix", Eigen::Matrix<double, 16, 1>::Zero());
      place.matrix() = Eigen::Map<const Eigen::Matrix4d>(numbers.data());
      return place;
    }
    place.translate(VectorOf<3>(json, "translation", Eigen::Vector3d::Zero()));
    place.rotate(Eigen::Quaterniond(VectorOf<4>(json, "rotation", Eigen::Vector4d(0, 0, 0, 1)))
                     .normalized());
    place.scale(VectorOf<3>(json, "scale", Eigen::Vector3d::Ones()));
    return place;
  }

  void TakeSkin(const Json& json) {
    file_.skins.push_back({IndicesAt(json, "joints"), IndexAt(json, "inverseBindMatrices")});
  }

  // --- looks ---

  GltfTextureInfo InfoOf(const Json& json) const {
    GltfTextureInfo info;
    info.texture = IndexAt(json, "index");
    info.uv_set = IndexAt(json, "texCoord", 0);
    const Json& moved = ExtensionOf(json, "KHR_texture_transform");
    if (!moved.is_object()) return info;
    info.uv_set = IndexAt(moved, "texCoord", info.uv_set);
    info.transform.translate(VectorOf<2>(moved, "offset", Eigen::Vector2d::Zero()));
    // Counter-clockwise as the picture is seen, and v points down.
    info.transform.rotate(Eigen::Rotation2Dd(-moved.value("rotation", 0.0)));
    info.transform.scale(VectorOf<2>(moved, "scale", Eigen::Vector2d::Ones()));
    if (!info.transform.matrix().allFinite())
      file_.Refuse("it is damaged (KHR_texture_transform is not finite)");
    return info;
  }

  /// The base colour; of a material that is black but shines, what shines.
  void TakeMaterial(const Json& json) {
    GltfMaterial material;
    const Json& older = ExtensionOf(json, "KHR_materials_pbrSpecularGlossiness");
    const auto plain = json.find("pbrMetallicRoughness");
    if (older.is_object())
      TakeColor(older, "diffuseTexture", "diffuseFactor", &material);
    else if (plain != json.end())
      TakeColor(*plain, "baseColorTexture", "baseColorFactor", &material);
    if (material.color.texture < 0 && material.factor.isZero())
      TakeColor(json, "emissiveTexture", "emissiveFactor", &material);
    file_.materials.push_back(material);
  }

  void TakeColor(const Json& json, const char* texture, const char* factor,
                 GltfMaterial* material) const {
    if (Has(json, texture)) material->color = InfoOf(json.at(texture));
    material->factor = VectorOf<3>(json, factor, material->factor);
  }

  static Wrap WrapOf(const Json& json, const char* key) {
    const int kind = json.value(key, 10497);
    if (kind == 33071) return Wrap::kClamp;
    return kind == 33648 ? Wrap::kMirror : Wrap::kRepeat;
  }

  void TakeSampler(const Json& json) {
    samplers_.emplace_back(WrapOf(json, "wrapS"), WrapOf(json, "wrapT"));
  }

  void TakeTexture(const Json& json) {
    GltfTexture texture;
    texture.image = IndexAt(json, "source");
    for (const char* name :
         {"EXT_texture_webp", "KHR_texture_basisu", "MSFT_texture_dds", "EXT_texture_avif"}) {
      const Json& extension = ExtensionOf(json, name);
      if (extension.is_object()) texture.images_of_extensions[name] = IndexAt(extension, "source");
    }
    const int sampler = IndexAt(json, "sampler");
    if (sampler >= 0) {
      const auto& [u, v] = file_.At(samplers_, sampler, "sampler");
      texture.wrap_u = u;
      texture.wrap_v = v;
    }
    file_.textures.push_back(std::move(texture));
  }

  void TakeImage(const Json& json) {
    GltfImage image;
    image.view = IndexAt(json, "bufferView");
    image.name = json.value("name", fmt::format("{} of {}", file_.images.size(), file_.name()));
    if (Has(json, "uri")) {
      const std::string uri = json.at("uri").get<std::string>();
      if (!uri.starts_with("data:")) image.name = PrintableName(WithoutPercents(uri));
      image.bytes = BytesOfUri(uri, &image.why).value_or("");
    }
    file_.images.push_back(std::move(image));
  }

  void TakeScene(const Json& root) {
    for (const std::size_t index : own_) file_.buffers[index].bytes = file_.buffers[index].own;
    const Json& scenes = ListOf(root, "scenes");
    if (!scenes.empty()) {
      const int shown = IndexAt(root, "scene", 0);
      if (shown >= SizeOf(scenes)) file_.Refuse("it is damaged (a scene that does not exist)");
      file_.roots = IndicesAt(scenes[static_cast<std::size_t>(shown)], "nodes");
      if (scenes.size() > 1 && !Has(root, "scene"))
        file_.warnings.push_back(
            fmt::format("{} has {} scenes and does not say which is shown: the first was taken",
                        file_.name(), scenes.size()));
      return;
    }
    std::vector<char> child(file_.nodes.size(), 0);
    for (const GltfNode& node : file_.nodes)
      for (const int c : node.children) {
        file_.At(file_.nodes, c, "node");
        child[static_cast<std::size_t>(c)] = 1;
      }
    for (int i = 0; i < SizeOf(child); ++i)
      if (!child[static_cast<std::size_t>(i)]) file_.roots.push_back(i);
  }

  GltfFile& file_;
  const fs::path& path_;
  std::string_view bytes_, json_text_;
  std::optional<std::string_view> binary_;
  std::vector<std::size_t> own_;  ///< buffers whose bytes are their own
  std::vector<std::pair<Wrap, Wrap>> samplers_;
};

}  // namespace

GltfFile::GltfFile(const fs::path& path) : name_(PrintableName(path)), bytes_(ReadFile(path)) {
  if (!LooksLikeGltf(std::string_view(bytes_).substr(0, 4096))) Refuse("it is no glTF");
  GltfParser(this, path, bytes_).Parse();
}

void GltfFile::Refuse(const std::string& why) const {
  throw InputError(
      fmt::format("{} cannot be read: {}; open it in Blender and export it as OBJ", name_, why));
}

bool LooksLikeGltf(std::string_view head) {
  if (head.starts_with("glTF")) return true;
  const std::size_t begin = head.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  return begin != head.npos && head[begin] == '{';
}

}  // namespace keypose
