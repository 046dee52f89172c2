#include "core/io/meshes/glb_mesh.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "core/io/meshes/gltf_data.h"
#include "core/io/meshes/gltf_file.h"
#include "core/io/pictures/image_kind.h"
#include "core/io/pictures/picture_bytes.h"
#include "core/pictures/srgb.h"
#include "core/surfaces/seams.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

constexpr double kHalfALevel = 0.5 / 255;
constexpr int kMostPlaced = 100000;  // nodes; one that contains itself would have no end
constexpr int kDeepest = 1000;
constexpr std::size_t kMostPoints = 50'000'000;

enum Mode { kTriangles = 4, kStrip = 5, kFan = 6 };

/// A part of a mesh with its numbers where they are packed together.
struct Part {
  const GltfPrimitive& primitive;
  std::optional<GltfData::Unpacked> unpacked;
};

/// Where a mesh stands, and how it is bent.
struct Stand {
  Eigen::Affine3d place = Eigen::Affine3d::Identity();
  std::vector<Eigen::Affine3d> joints;  ///< world from mesh, of each; empty: no skin
  std::vector<double> weights;          ///< of the shapes
};

/// What a material shows on a part.
struct Look {
  int page = -1;
  GltfTextureInfo info;
  Eigen::Vector3d factor = Eigen::Vector3d::Ones();  ///< linear light
};

class SceneReader {
 public:
  SceneReader(const fs::path& path, bool join) : file_(path), data_(file_), join_(join) {}

  GlbMesh Read() {
    FindWorld();
    warnings_ = file_.warnings;
    for (const int root : file_.roots) Place(root, 0);
    if (faces_.empty()) RefuseEmpty();
    if (skipped_ > 0)
      Warn(fmt::format("{} of its parts are lines or points, and were left out", skipped_));
    GlbMesh result;
    result.paged = Joined();
    result.warnings = std::move(warnings_);
    return result;
  }

 private:
  [[noreturn]] void RefuseEmpty() const {
    if (splats_ > 0)
      file_.Refuse("it holds Gaussian splats (KHR_gaussian_splatting) and no triangles");
    file_.Refuse("it has no triangles");
  }

  void Warn(const std::string& what) {
    const std::string text = fmt::format("{}: {}", file_.name(), what);
    if (std::find(warnings_.begin(), warnings_.end(), text) == warnings_.end())
      warnings_.push_back(text);
  }

  /// Where each node lies. Joints may be anywhere in the tree.
  void FindWorld() {
    std::vector<int> parent(file_.nodes.size(), -1);
    for (int n = 0; n < SizeOf(file_.nodes); ++n)
      for (const int child : file_.nodes[n].children) {
        file_.At(file_.nodes, child, "node");
        if (parent[child] >= 0) file_.Refuse("it is damaged (a node that lies in two others)");
        parent[child] = n;
      }
    for (int n = 0; n < SizeOf(file_.nodes); ++n) {
      Eigen::Affine3d place = Eigen::Affine3d::Identity();
      int depth = 0;
      for (int at = n; at >= 0; at = parent[at]) {
        if (++depth > kDeepest) file_.Refuse("it is damaged (nodes that contain each other)");
        place = file_.nodes[at].parent_from_node * place;
      }
      world_.push_back(place);
    }
  }

  void Place(int index, int depth) {
    if (++placed_ > kMostPlaced || depth > kDeepest)
      file_.Refuse("it is damaged (nodes that contain each other)");
    const GltfNode& node = file_.At(file_.nodes, index, "node");
    if (!node.visible) return;
    if (node.mesh >= 0) PlaceMesh(node, world_[index]);
    for (const int child : node.children) Place(child, depth + 1);
  }

  void PlaceMesh(const GltfNode& node, const Eigen::Affine3d& place) {
    const GltfMesh& mesh = file_.At(file_.meshes, node.mesh, "mesh");
    Stand stand;
    stand.weights = node.weights.empty() ? mesh.weights : node.weights;
    if (node.skin >= 0) stand.joints = JointsOf(file_.At(file_.skins, node.skin, "skin"));
    for (const Eigen::Affine3d& instance : InstancesOf(node)) {
      stand.place = place * instance;
      for (const GltfPrimitive& part : mesh.primitives) AddPart(part, stand);
    }
  }

  std::vector<Eigen::Affine3d> JointsOf(const GltfSkin& skin) {
    std::vector<Eigen::Affine3d> joints;
    for (const int joint : skin.joints) {
      file_.At(file_.nodes, joint, "joint");
      joints.push_back(world_[joint]);
    }
    if (joints.empty()) file_.Refuse("it is damaged (a skin without joints)");
    if (skin.inverse_bind < 0) return joints;
    const GltfRows binds = data_.Numbers(skin.inverse_bind);
    if (binds.cols() != 16 || binds.rows() < std::ssize(joints))
      file_.Refuse("it is damaged (inverseBindMatrices)");
    for (std::size_t j = 0; j < joints.size(); ++j) {
      Eigen::Affine3d bind;
      bind.matrix() = Eigen::Map<const Eigen::Matrix4d>(binds.data() + 16 * j);
      joints[j] = joints[j] * bind;
    }
    return joints;
  }

  /// EXT_mesh_gpu_instancing; a node without it stands once.
  std::vector<Eigen::Affine3d> InstancesOf(const GltfNode& node) {
    if (node.instances.empty()) return {Eigen::Affine3d::Identity()};
    const auto rows_of = [&](const char* name, int columns) {
      const auto it = node.instances.find(name);
      GltfRows rows = it == node.instances.end() ? GltfRows() : data_.Numbers(it->second);
      if (rows.rows() > 0 && rows.cols() < columns)
        file_.Refuse("it is damaged (EXT_mesh_gpu_instancing)");
      return rows;
    };
    const GltfRows moves = rows_of("TRANSLATION", 3), turns = rows_of("ROTATION", 4),
                   scales = rows_of("SCALE", 3);
    const Eigen::Index count = std::max({moves.rows(), turns.rows(), scales.rows()});
    if (count > kMostPlaced) file_.Refuse("it has too many instances");
    std::vector<Eigen::Affine3d> instances;
    for (Eigen::Index i = 0; i < count; ++i) {
      Eigen::Affine3d place = Eigen::Affine3d::Identity();
      if (i < moves.rows()) place.translate(Eigen::Vector3d(moves.row(i).head<3>()));
      if (i < turns.rows())
        place.rotate(Eigen::Quaterniond(Eigen::Vector4d(turns.row(i).head<4>())).normalized());
      if (i < scales.rows()) place.scale(Eigen::Vector3d(scales.row(i).head<3>()));
      instances.push_back(place);
    }
    return instances;
  }

  /// Empty: the part has none.
  /// @throws InputError  not one row a vertex, or too few columns
  GltfRows Attribute(const Part& part, const std::string& name, int columns,
                     Eigen::Index vertices = -1) {
    GltfRows rows;
    const auto it = part.primitive.attributes.find(name);
    if (part.unpacked && part.unpacked->attributes.contains(name))
      rows = part.unpacked->attributes.at(name);
    else if (it != part.primitive.attributes.end())
      rows = data_.Numbers(it->second);
    else
      return rows;
    if (rows.cols() < columns || (vertices >= 0 && rows.rows() != vertices))
      file_.Refuse(fmt::format("it is damaged ({})", name));
    return rows;
  }

  /// The same, with the shapes that are switched on.
  GltfRows Shaped(const Part& part, const Stand& stand, const std::string& name, int columns,
                  Eigen::Index vertices = -1) {
    GltfRows rows = Attribute(part, name, columns, vertices);
    const std::vector<GltfAttributes>& targets = part.primitive.targets;
    for (std::size_t t = 0; t < std::min(targets.size(), stand.weights.size()); ++t) {
      const auto it = targets[t].find(name);
      if (stand.weights[t] == 0 || it == targets[t].end() || rows.rows() == 0) continue;
      const GltfRows change = data_.Numbers(it->second);
      if (change.rows() != rows.rows() || change.cols() > rows.cols())
        file_.Refuse(fmt::format("it is damaged (a shape's {})", name));
      rows.leftCols(change.cols()) += stand.weights[t] * change;
    }
    return rows;
  }

  void AddPart(const GltfPrimitive& primitive, const Stand& stand) {
    splats_ += primitive.splats;
    if (primitive.mode < kTriangles || primitive.mode > kFan) {
      ++skipped_;
      return;
    }
    Part part{primitive, std::nullopt};
    if (data_.IsDraco(primitive)) part.unpacked = data_.Draco(primitive);
    const GltfRows points = Shaped(part, stand, "POSITION", 3);
    const Eigen::Index count = points.rows();
    if (points_.size() + static_cast<std::size_t>(count) > kMostPoints)
      file_.Refuse("it has too many vertices");
    const int first = SizeOf(points_);
    const bool mirrored = AddPoints(part, stand, points);
    const Look look = AddColors(part, stand, count);
    AddUvs(part, stand, look, count);
    AddFaces(part, first, static_cast<int>(count), mirrored, look.page);
  }

  /// Makes room at once, but for many small parts no more often than is usual.
  template <class T>
  static void Reserve(std::vector<T>* list, Eigen::Index more) {
    const std::size_t wanted = list->size() + static_cast<std::size_t>(more);
    if (wanted > list->capacity()) list->reserve(std::max(wanted, 2 * list->size()));
  }

  /// @return whether the part is turned inside out by its place
  bool AddPoints(const Part& part, const Stand& stand, const GltfRows& points) {
    const bool skinned = !stand.joints.empty() && part.primitive.attributes.contains("JOINTS_0");
    double orientation = 0;
    std::vector<Eigen::Affine3d> bends;
    Reserve(&points_, points.rows());
    if (skinned) bends = BendsOf(part, stand, points.rows());
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const Eigen::Affine3d& place = skinned ? bends[i] : stand.place;
      const Eigen::Vector3d p = place * Eigen::Vector3d(points.row(i).head<3>()) + file_.center;
      if (!p.allFinite()) file_.Refuse("it has a vertex that is not finite");
      points_.emplace_back(p.x(), -p.z(), p.y());  // y up becomes z up
      if (skinned) orientation += place.linear().determinant();
    }
    return (skinned ? orientation : stand.place.linear().determinant()) < 0;
  }

  /// The weighted mean of the joints' transforms, of each vertex. The node's own place does not
  /// count.
  std::vector<Eigen::Affine3d> BendsOf(const Part& part, const Stand& stand, Eigen::Index count) {
    std::vector<Eigen::Matrix4d> sums(static_cast<std::size_t>(count), Eigen::Matrix4d::Zero());
    for (int set = 0;; ++set) {
      const GltfRows joints = Attribute(part, fmt::format("JOINTS_{}", set), 4, count),
                     weights = Attribute(part, fmt::format("WEIGHTS_{}", set), 4, count);
      if (joints.rows() == 0 && weights.rows() == 0) break;
      if (joints.rows() != weights.rows())
        file_.Refuse(fmt::format("it is damaged (JOINTS_{} without WEIGHTS_{})", set, set));
      for (Eigen::Index i = 0; i < count; ++i)
        for (int k = 0; k < 4; ++k)
          if (weights(i, k) != 0)
            sums[static_cast<std::size_t>(i)] +=
                weights(i, k) *
                file_.At(stand.joints, static_cast<int>(joints(i, k)), "joint").matrix();
    }
    std::vector<Eigen::Affine3d> bends(sums.size(), stand.joints[0]);
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const double sum = sums[i](3, 3);
      if (sum > 0) bends[i].matrix() = sums[i] / sum;  // no weights: the first joint has it
    }
    return bends;
  }

  /// Adds the colours of the vertices: the material's times their own. A colour that all vertices
  /// of a textured part share belongs to its page.
  Look AddColors(const Part& part, const Stand& stand, Eigen::Index count) {
    const GltfRows own = Shaped(part, stand, "COLOR_0", 3, count);
    Look look = LookOf(part.primitive);
    TexturePage page;
    const bool textured = FindPage(part, &look, &page);
    if (textured) {
      page.factor = look.factor;
      if (own.rows() > 0) TintPage(own, &page);
      if (page.factor.isOnes(kHalfALevel)) page.factor.setOnes();  // rounded integers
      look.page = paged_.PageOf(page);
    }
    AddColorsOf(own, look.factor, static_cast<std::size_t>(count));
    return look;
  }

  /// White is kept only beside others.
  void AddColorsOf(const GltfRows& own, const Eigen::Vector3d& factor, std::size_t count) {
    has_colors_ |= own.rows() > 0 || factor != Eigen::Vector3d::Ones();
    if (!has_colors_) return;
    colors_.resize(points_.size() - count, Eigen::Vector3d::Ones());
    for (std::size_t i = 0; i < count; ++i) {
      Eigen::Vector3d color = factor;
      if (own.rows() > 0)
        color.array() *= own.row(static_cast<Eigen::Index>(i)).head<3>().transpose().array();
      colors_.push_back(color);
    }
  }

  void TintPage(const GltfRows& own, TexturePage* page) {
    const Eigen::RowVector3d least = own.leftCols<3>().colwise().minCoeff(),
                             most = own.leftCols<3>().colwise().maxCoeff();
    if ((most - least).maxCoeff() <= 2 * kHalfALevel)
      page->factor.array() *= most.transpose().array();
    else
      Warn(
          "its vertices have colours (COLOR_0) that tint its texture, which were left out: bake "
          "them into the texture first");
  }

  Look LookOf(const GltfPrimitive& primitive) const {
    Look look;
    if (primitive.material < 0) return look;
    const GltfMaterial& material = file_.At(file_.materials, primitive.material, "material");
    look.info = material.color;
    look.factor = material.factor;
    return look;
  }

  /// Finds the page of a part with a texture that can be used.
  bool FindPage(const Part& part, Look* look, TexturePage* page) {
    if (look->info.texture < 0) return false;
    const std::string coordinates = fmt::format("TEXCOORD_{}", look->info.uv_set);
    if (!part.primitive.attributes.contains(coordinates)) {
      Warn(fmt::format("a part names a texture, but has no {}: it has one colour", coordinates));
      return false;
    }
    const GltfTexture& texture = file_.At(file_.textures, look->info.texture, "texture");
    page->picture = PictureOf(texture);
    page->wrap_u = texture.wrap_u;
    page->wrap_v = texture.wrap_v;
    return page->picture >= 0;
  }

  /// The first of a texture's pictures that can be read; -1: none, which is said.
  int PictureOf(const GltfTexture& texture) {
    std::map<std::string, int> sources = texture.images_of_extensions;
    if (texture.image >= 0) sources[""] = texture.image;  // comes first
    for (const auto& [extension, index] : sources) {
      file_.At(file_.images, index, "picture");
      const int picture = PictureIndex(index);
      if (!PictureBytesKind(paged_.pictures[picture].bytes).empty()) return picture;
    }
    SayNoPicture(sources);
    return -1;
  }

  /// @throws InputError  the file needs the extension of one of them
  void SayNoPicture(const std::map<std::string, int>& sources) {
    if (sources.empty()) return Warn("a texture of it names no picture");
    for (const auto& [extension, index] : sources)
      if (file_.required.contains(extension))
        file_.Refuse(fmt::format("it needs the extension {}, which is not read", extension));
    const auto& [extension, index] = *sources.begin();
    const std::string& why = file_.images[index].why;
    if (!why.empty()) return Warn(why);
    const std::string cure = "which is not read, and is left out: export it with PNG or JPEG";
    if (!extension.empty())
      return Warn(fmt::format("its texture is of the extension {}, {}", extension, cure));
    const std::string kind = OtherKindOf(
        std::string_view(paged_.pictures[picture_of_image_[index]].bytes).substr(0, 64));
    Warn(fmt::format("its texture is {}, {}", kind.empty() ? "neither PNG, JPEG nor WebP" : kind,
                     cure));
  }

  int PictureIndex(int image_index) {
    const auto found = picture_of_image_.find(image_index);
    if (found != picture_of_image_.end()) return found->second;
    const GltfImage& image = file_.images[image_index];
    std::string bytes = image.view >= 0 ? std::string(data_.Bytes(image.view)) : image.bytes;
    const int picture = SizeOf(paged_.pictures);
    paged_.pictures.push_back({image.name, std::move(bytes)});
    picture_of_image_[image_index] = picture;
    return picture;
  }

  void AddUvs(const Part& part, const Stand& stand, const Look& look, Eigen::Index count) {
    const GltfRows uvs =
        look.page < 0 ? GltfRows()
                      : Shaped(part, stand, fmt::format("TEXCOORD_{}", look.info.uv_set), 2, count);
    Reserve(&uvs_, count);
    if (uvs.rows() == 0) uvs_.resize(uvs_.size() + static_cast<std::size_t>(count), {0, 0});
    for (Eigen::Index i = 0; i < uvs.rows(); ++i) {
      const Eigen::Vector2d uv =
          look.info.transform * Eigen::Vector2d(uvs.row(i).head<2>().transpose());
      if (!uv.allFinite()) file_.Refuse("it has a texture coordinate that is not finite");
      uvs_.emplace_back(uv.x(), 1 - uv.y());
    }
  }

  void AddFaces(const Part& part, int first, int count, bool mirrored, int page) {
    GltfRows corners;
    if (part.unpacked) {
      corners = part.unpacked->corners;
    } else if (part.primitive.indices >= 0) {
      corners = data_.Numbers(part.primitive.indices);
    } else {
      corners.resize(count, 1);
      for (int i = 0; i < count; ++i) corners(i, 0) = i;
    }
    for (Eigen::Index i = 0; i < corners.rows(); ++i)
      if (!(corners(i, 0) >= 0 && corners(i, 0) < count))
        file_.Refuse("it is damaged (a corner that does not exist)");
    const int mode = part.unpacked ? static_cast<int>(kTriangles) : part.primitive.mode;
    const Eigen::Index step = mode == kTriangles ? 3 : 1;
    Reserve(&faces_, corners.rows() / step);
    Reserve(&paged_.page_of_face, corners.rows() / step);
    for (Eigen::Index i = 0; i + 2 < corners.rows(); i += step) {
      const bool odd = mode == kStrip && i % 2 == 1;
      const Eigen::Index start = mode == kFan ? 0 : i;
      Eigen::Vector3i face(static_cast<int>(corners(start, 0)), static_cast<int>(corners(i + 1, 0)),
                           static_cast<int>(corners(i + 2, 0)));
      if (odd != mirrored) std::swap(face[1], face[2]);
      if (face[0] == face[1] || face[1] == face[2] || face[0] == face[2]) continue;
      faces_.push_back(face.array() + first);
      paged_.page_of_face.push_back(page);
    }
  }

  static std::uint8_t LevelOf(double linear) {
    return static_cast<std::uint8_t>(
        std::lround(255 * SrgbFromLinear(std::clamp(linear, 0.0, 1.0))));
  }

  PagedMesh Joined() {
    Mesh flat;
    flat.points = Eigen::Map<const PointsX3>(points_[0].data(), SizeOf(points_), 3);
    flat.faces = Eigen::Map<const FacesX3>(faces_[0].data(), SizeOf(faces_), 3);
    WeldedMesh welded = join_ ? WeldWholeFaces(flat) : Weld(flat, {});
    paged_.mesh = std::move(welded.mesh);
    if (!paged_.pages.empty())
      TakeUvs(std::move(flat.faces));
    else if (has_colors_)
      TakeColors(welded.of_input);
    return std::move(paged_);
  }

  void TakeUvs(FacesX3 faces) {
    Mesh& mesh = paged_.mesh;
    mesh.uv_faces = std::move(faces);
    mesh.uvs = Eigen::Map<const UvsX2>(uvs_[0].data(), SizeOf(uvs_), 2);
    const std::vector<int>& pages = paged_.page_of_face;
    if (std::find(pages.begin(), pages.end(), -1) == pages.end()) return;
    colors_.resize(points_.size(), Eigen::Vector3d::Ones());
    for (const Eigen::Vector3i& face : faces_)
      paged_.corner_colors.push_back({colors_[face[0]], colors_[face[1]], colors_[face[2]]});
  }

  void TakeColors(const std::vector<int>& of_input) {
    colors_.resize(points_.size(), Eigen::Vector3d::Ones());
    Mesh& mesh = paged_.mesh;
    mesh.colors.resize(mesh.points.rows(), 3);
    for (int i = SizeOf(points_) - 1; i >= 0; --i)
      for (int c = 0; c < 3; ++c) mesh.colors(of_input[i], c) = LevelOf(colors_[i][c]);
  }

  GltfFile file_;
  GltfData data_;
  PagedMesh paged_;
  std::vector<std::string> warnings_;
  std::vector<Eigen::Affine3d> world_;  ///< world from node
  std::map<int, int> picture_of_image_;
  std::vector<Eigen::Vector3d> points_, colors_;
  std::vector<Eigen::Vector2d> uvs_;
  std::vector<Eigen::Vector3i> faces_;
  bool join_ = true, has_colors_ = false;
  int placed_ = 0, skipped_ = 0, splats_ = 0;
};

}  // namespace

GlbMesh ReadGlb(const fs::path& path, bool join_seams) {
  return SceneReader(path, join_seams).Read();
}

}  // namespace keypose
