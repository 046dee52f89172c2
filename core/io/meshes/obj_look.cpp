#include "core/io/meshes/obj_look.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "core/io/meshes/beside.h"
#include "core/io/meshes/face_colors.h"
#include "core/io/meshes/mtl_file.h"
#include "core/io/text/files.h"
#include "core/pictures/srgb.h"
#include "core/values/file_names.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

struct NamedMaterial {
  MtlMaterial of_file;
  fs::path library;
};

/// The names in an `mtllib` line, where the whole is not one: each ends with .mtl, or stands
/// between spaces.
std::vector<std::string> LibraryNames(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> names;
  std::string name;
  for (std::string word; in >> word;) {
    name += (name.empty() ? "" : " ") + word;
    if (!LowerCase(word).ends_with(".mtl")) continue;
    names.push_back(std::exchange(name, ""));
  }
  if (!name.empty()) names.push_back(name);
  return names;
}

/// As Mari, Blender, Maya and Houdini write what stands for the tile's number.
bool IsUdim(const std::string& file) {
  for (const char* mark : {"<UDIM>", "<udim>", "<UVTILE>", "%(UDIM)d", "_MAPID_"})
    if (file.find(mark) != std::string::npos) return true;
  return false;
}

class ObjLookReader {
 public:
  ObjLookReader(const fs::path& path, ObjFile obj) : path_(path), obj_(std::move(obj)) {}

  ObjLook Read() {
    ReadLibraries();
    for (const std::string& name : obj_.materials) chosen_.push_back(MaterialOf(name));
    look_.paged.mesh = std::move(obj_.mesh);
    FindPages();
    if (!look_.paged.pages.empty())
      PutPages();
    else
      PutColors();
    for (const std::string& statement : obj_.left_out) Warn(statement);
    if (obj_.has_texture_maps)
      Warn("it names textures by usemap, which is not read: name them in a material (map_Kd)");
    return std::move(look_);
  }

 private:
  void Warn(const std::string& what) {
    const std::string text = fmt::format("{}: {}", PrintableName(path_), what);
    if (std::find(look_.warnings.begin(), look_.warnings.end(), text) == look_.warnings.end())
      look_.warnings.push_back(text);
  }

  void ReadLibraries() {
    for (const std::string& line : obj_.libraries) {
      std::string whole = line;
      if (whole.size() > 1 && whole.front() == '"' && whole.back() == '"')
        whole = whole.substr(1, whole.size() - 2);
      const fs::path one = FileBeside(path_, whole);
      if (!one.empty()) {
        ReadLibrary(one);
        continue;
      }
      for (const std::string& name : LibraryNames(line)) {
        const fs::path file = FileBeside(path_, name);
        if (file.empty())
          missing_.push_back(name);
        else
          ReadLibrary(file);
      }
    }
  }

  void ReadLibrary(const fs::path& file) {
    for (MtlMaterial& material : ParseMtl(ReadFile(file)))
      materials_.push_back({std::move(material), file});
  }

  /// Null: the libraries do not have it. Faces without a material are of the only one, or of the
  /// only one that has a texture.
  const NamedMaterial* MaterialOf(const std::string& name) const {
    for (const NamedMaterial& material : materials_)
      if (material.of_file.name == name && !name.empty()) return &material;
    for (const NamedMaterial& material : materials_)
      if (LowerCase(material.of_file.name) == LowerCase(name) && !name.empty()) return &material;
    if (materials_.size() == 1) return &materials_[0];
    if (!name.empty()) return nullptr;
    const NamedMaterial* textured = nullptr;
    for (const NamedMaterial& material : materials_) {
      if (material.of_file.map.file.empty()) continue;
      if (textured) return nullptr;
      textured = &material;
    }
    return textured;
  }

  void FindPages() {
    const bool has_uvs = look_.paged.mesh.has_uvs();
    bool named = false;
    for (const NamedMaterial* material : chosen_) {
      const bool textured = material && !material->of_file.map.file.empty();
      named |= textured;
      page_of_material_.push_back(textured && has_uvs ? PageOf(*material) : -1);
      if (!material || page_of_material_.back() >= 0) continue;
      for (const std::string& statement : material->of_file.left_out)
        Warn(
            fmt::format("the colour {} of a material is left out: write it as Kd with red, green "
                        "and blue",
                        statement));
    }
    if (named && !has_uvs)
      Warn(
          "its material names a texture, but it has no texture coordinates (vt): export it with "
          "them");
    if (!missing_.empty() && (!named || NamesUnknownMaterial()))
      Warn(
          fmt::format("it names its materials in {}, which is not there: put it beside the mesh, "
                      "with the texture",
                      PrintableName(missing_[0])));
    else if (NamesUnknownMaterial() && !materials_.empty())
      Warn("some of its faces are of a material that its MTL does not have");
  }

  bool NamesUnknownMaterial() const {
    for (int m = 0; m < SizeOf(chosen_); ++m)
      if (!chosen_[m] && !obj_.materials[m].empty()) return true;
    return false;
  }

  /// The page of a material's texture; -1: it is not there, which is said.
  int PageOf(const NamedMaterial& material) {
    const MtlMap& map = material.of_file.map;
    for (const std::string& option : map.left_out)
      Warn(fmt::format("the option {} of the texture {} is left out: bake it into the texture",
                       option, PrintableName(map.file)));
    fs::path file = FileBeside(material.library, map.file);
    if (file.empty()) file = FileBeside(path_, map.file);
    if (file.empty()) {
      const std::string name = PrintableName(map.file);
      Warn(IsUdim(map.file)
               ? fmt::format("its texture {} stands for UDIM tiles, which are not read: bake them "
                             "into one square and one picture, or give each tile its material",
                             name)
               : fmt::format("it names the texture {}, which is not there: put it beside the mesh",
                             name));
      return -1;
    }
    TexturePage page;
    page.picture = PictureOf(file);
    if (map.clamped) page.wrap_u = page.wrap_v = Wrap::kClamp;
    return look_.paged.PageOf(page);
  }

  int PictureOf(const fs::path& file) {
    const auto found = std::find(look_.files.begin(), look_.files.end(), file);
    const int index = static_cast<int>(found - look_.files.begin());
    if (found == look_.files.end()) {
      look_.files.push_back(file);
      look_.paged.pictures.push_back({PrintableName(file.filename()), ReadFile(file)});
    }
    return index;
  }

  void PutPages() {
    bool bare = false;
    for (const int material : obj_.material_of_face) {
      look_.paged.page_of_face.push_back(page_of_material_[material]);
      bare |= page_of_material_[material] < 0;
    }
    MoveUvs();
    look_.moved |= bare || look_.paged.pages.size() > 1;
    if (bare) PutCornerColors();
    look_.paged.mesh.colors.resize(0, 3);
  }

  /// Applies -s and -o. Materials may share coordinates: each that moves gets its own.
  void MoveUvs() {
    Mesh& mesh = look_.paged.mesh;
    std::map<std::pair<int, int>, int> moved;
    std::vector<Eigen::RowVector2d> uvs;
    const auto given = static_cast<int>(mesh.uvs.rows());
    for (Eigen::Index f = 0; f < mesh.uv_faces.rows(); ++f) {
      const int material = obj_.material_of_face[static_cast<std::size_t>(f)];
      if (page_of_material_[material] < 0) continue;
      const MtlMap& map = chosen_[material]->of_file.map;
      if (map.scale == Eigen::Vector2d::Ones() && map.offset.isZero(0)) continue;
      for (int k = 0; k < 3; ++k) {
        int& uv = mesh.uv_faces(f, k);
        const auto [entry, is_new] = moved.emplace(std::pair(material, uv), given + SizeOf(uvs));
        if (is_new)
          uvs.push_back(mesh.uvs.row(uv).cwiseProduct(map.scale.transpose()) +
                        map.offset.transpose());
        uv = entry->second;
      }
    }
    if (uvs.empty()) return;
    look_.moved = true;
    mesh.uvs.conservativeResize(given + std::ssize(uvs), 2);
    for (int i = 0; i < SizeOf(uvs); ++i) mesh.uvs.row(given + i) = uvs[i];
  }

  static Eigen::Vector3d Linear(const Eigen::Vector3d& srgb) {
    return srgb.unaryExpr([](double s) { return LinearFromSrgb(std::clamp(s, 0.0, 1.0)); });
  }

  /// Kd, or white.
  Eigen::Vector3d ColorOf(int material) const {
    const NamedMaterial* of_file = chosen_[material];
    return of_file ? of_file->of_file.color.value_or(Eigen::Vector3d::Ones())
                   : Eigen::Vector3d::Ones();
  }

  /// Of faces without a texture beside others: the vertices' colours, or else the material's.
  void PutCornerColors() {
    const Mesh& mesh = look_.paged.mesh;
    for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
      std::array<Eigen::Vector3d, 3> corners;
      corners.fill(Linear(ColorOf(obj_.material_of_face[static_cast<std::size_t>(f)])));
      for (int k = 0; k < 3 && mesh.colors.rows() > 0; ++k)
        corners[k] = Linear(mesh.colors.row(mesh.faces(f, k)).transpose().cast<double>() / 255);
      look_.paged.corner_colors.push_back(corners);
    }
  }

  /// Whether the materials' colours tell more than that the figure is grey.
  bool HasColors() const {
    std::set<std::array<double, 3>> colors;
    bool grey = true;
    for (int m = 0; m < SizeOf(chosen_); ++m) {
      const Eigen::Vector3d color = ColorOf(m);
      colors.insert({color[0], color[1], color[2]});
      grey &= color[0] == color[1] && color[1] == color[2];
    }
    return colors.size() > 1 || !grey;
  }

  /// Without a texture: the vertices' own colours, or else the mean of their faces' materials.
  void PutColors() {
    Mesh& mesh = look_.paged.mesh;
    if (mesh.colors.rows() > 0 || !HasColors()) return;
    Eigen::MatrixX3d levels(mesh.faces.rows(), 3);
    for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
      levels.row(f) = 255 * ColorOf(obj_.material_of_face[static_cast<std::size_t>(f)])
                                .transpose()
                                .cwiseMax(0)
                                .cwiseMin(1);
    if (TakeFaceColors(levels, &mesh)) Warn(kColorsBlend);
    look_.moved = true;
  }

  const fs::path& path_;
  ObjFile obj_;
  ObjLook look_;
  std::vector<NamedMaterial> materials_;
  std::vector<std::string> missing_;          // libraries
  std::vector<const NamedMaterial*> chosen_;  // of obj_.materials
  std::vector<int> page_of_material_;
};

}  // namespace

ObjLook LookOfObj(const fs::path& path, ObjFile obj) {
  return ObjLookReader(path, std::move(obj)).Read();
}

}  // namespace keypose
