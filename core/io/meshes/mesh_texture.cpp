#include "core/io/meshes/mesh_texture.h"

#define TINYOBJLOADER_USE_DOUBLE
#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

constexpr int kMostHeaderLines = 1000;  // of a PLY

/// The rest of a line after a word, without spaces and a carriage return at its ends.
std::optional<std::string> After(const std::string& word, const std::string& line) {
  if (!line.starts_with(word)) return std::nullopt;
  const auto begin = line.find_first_not_of(" \t", word.size());
  if (begin == std::string::npos) return std::nullopt;
  return line.substr(begin, line.find_last_not_of(" \t\r") + 1 - begin);
}

/// A file that a mesh names, in the mesh's folder or below; else the one of its name there. Empty:
/// there is none.
fs::path Beside(const fs::path& mesh, std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  if (name.starts_with("./")) name.erase(0, 2);
  std::error_code ignored;
  for (const std::string& candidate : {name, fs::path(name).filename().string()}) {
    if (!StaysBelow(candidate)) continue;
    const fs::path file = mesh.parent_path() / candidate;
    if (fs::is_regular_file(file, ignored)) return file;
  }
  return {};
}

struct ObjNames {
  std::vector<std::string> libraries;
  std::set<std::string> materials;  ///< that have faces
};

ObjNames NamesIn(std::istream& in) {
  ObjNames names;
  std::string material;
  for (std::string line; std::getline(in, line);) {
    if (const auto library = After("mtllib ", line)) names.libraries.push_back(*library);
    if (const auto used = After("usemtl ", line)) material = *used;
    if (line.starts_with("f ")) names.materials.insert(material);
  }
  return names;
}

MeshTexture Found(const fs::path& mesh, const std::set<std::string>& textures) {
  const std::string who = PrintableName(mesh);
  if (textures.empty()) return {};
  if (textures.size() > 1)
    return {{},
            fmt::format("{} has {} textures, but one is used: bake them into one layout and one "
                        "texture in your scanning or modelling program first",
                        who, textures.size())};
  fs::path file = Beside(mesh, *textures.begin());
  if (file.empty())
    return {{},
            fmt::format("{} names the texture {}, which is not there: put it beside the mesh", who,
                        PrintableName(*textures.begin()))};
  return {std::move(file), ""};
}

MeshTexture TextureOfObj(const fs::path& mesh, std::istream& in) {
  const ObjNames names = NamesIn(in);
  std::set<std::string> textures;
  std::string missing;
  for (const std::string& library : names.libraries) {
    const fs::path file = Beside(mesh, library);
    std::ifstream text(file);
    if (file.empty() || !text) {
      missing = library;
      continue;
    }
    std::map<std::string, int> index;
    std::vector<tinyobj::material_t> materials;
    std::string warning, error;
    tinyobj::LoadMtl(&index, &materials, &text, &warning, &error);
    for (const tinyobj::material_t& material : materials)
      if (names.materials.contains(material.name) && !material.diffuse_texname.empty())
        textures.insert(material.diffuse_texname);
  }
  if (textures.empty() && !missing.empty())
    return {{},
            fmt::format("{} names its materials in {}, which is not there: put it beside the mesh, "
                        "with the texture",
                        PrintableName(mesh), PrintableName(missing))};
  return Found(mesh, textures);
}

MeshTexture TextureOfPly(const fs::path& mesh, std::istream& in) {
  std::set<std::string> textures;
  std::string line;
  for (int i = 0; i < kMostHeaderLines && std::getline(in, line); ++i) {
    if (line.starts_with("end_header")) break;
    if (const auto texture = After("comment TextureFile ", line)) textures.insert(*texture);
  }
  return Found(mesh, textures);
}

}  // namespace

MeshTexture FindTexture(const fs::path& mesh) {
  std::ifstream in(mesh, std::ios::binary);
  if (!in) throw DiskError(fmt::format("{} cannot be opened", PrintableName(mesh)));
  const std::string extension = LowerExtension(mesh);
  if (extension == ".obj") return TextureOfObj(mesh, in);
  if (extension == ".ply") return TextureOfPly(mesh, in);
  return {};
}

}  // namespace keypose
