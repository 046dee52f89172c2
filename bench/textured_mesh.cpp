#include "bench/textured_mesh.h"

#include <fstream>
#include <map>
#include <sstream>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/pictures/render.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::bench {
namespace fs = std::filesystem;
namespace {

std::ifstream Open(const fs::path& path) {
  std::ifstream file(path);
  if (!file)
    throw DiskError(path.string() +
                    " cannot be opened; the mesh refers to it: put it beside the mesh");
  return file;
}

/// The rest of a line, trimmed: names may contain blanks.
std::string Rest(std::istream& line) {
  std::string rest;
  std::getline(line >> std::ws, rest);
  while (!rest.empty() && (rest.back() == '\r' || rest.back() == ' ')) rest.pop_back();
  return rest;
}

/// The texture file of each material that has one.
std::map<std::string, fs::path> ReadMaterials(const fs::path& path) {
  std::map<std::string, fs::path> textures;
  std::ifstream file = Open(path);
  std::string text, material;
  while (std::getline(file, text)) {
    std::istringstream line(text);
    std::string word;
    line >> word;
    if (word == "newmtl") material = Rest(line);
    if (word == "map_Kd") textures[material] = path.parent_path() / Rest(line);
  }
  return textures;
}

int CountWords(std::istream& line) {
  int count = 0;
  for (std::string word; line >> word;) ++count;
  return count;
}

/// Reads the lines of an OBJ that core's reader ignores. Splits polygons into fans, like that
/// reader.
void ReadPages(const fs::path& path, TexturedMesh& result) {
  std::map<std::string, fs::path> textures;
  std::map<std::string, int> page_of_material;
  std::ifstream file = Open(path);
  std::string text, material;
  int page = -1, number = 0;
  while (std::getline(file, text)) {
    ++number;
    std::istringstream line(text);
    std::string word;
    line >> word;
    if (word == "mtllib") textures.merge(ReadMaterials(path.parent_path() / Rest(line)));
    if (word == "usemtl") {
      material = Rest(line);
      const auto [entry, is_new] = page_of_material.emplace(material, SizeOf(result.pages));
      if (is_new && textures.count(material) == 0)
        throw InputError(path.string() + " line " + std::to_string(number) +
                         ": no texture (map_Kd) is known for material '" + material + "'");
      if (is_new) result.pages.push_back(ReadImage(textures.at(material), 3));
      page = entry->second;
    }
    if (word == "f")
      result.page_of_face.insert(result.page_of_face.end(),
                                 static_cast<std::size_t>(std::max(0, CountWords(line) - 2)), page);
  }
}

void CheckPages(const fs::path& path, const TexturedMesh& result) {
  if (result.pages.empty()) return;
  if (!result.mesh.has_uvs())
    throw InputError(path.string() +
                     " has a texture, but no texture coordinates; pass the unwrapped mesh");
  if (SizeOf(result.page_of_face) != result.mesh.face_count())
    throw InputError(path.string() + ": materials are given for " +
                     std::to_string(result.page_of_face.size()) + " triangles of " +
                     std::to_string(result.mesh.face_count()));
  for (std::size_t f = 0; f < result.page_of_face.size(); ++f)
    if (result.page_of_face[f] < 0)
      throw InputError(path.string() + ": face " + std::to_string(f) +
                       " comes before the first 'usemtl'");
}

}  // namespace

Eigen::Vector3d TexturedMesh::ColorAt(int face, double u, double v) const {
  const double w[3] = {1 - u - v, u, v};
  if (pages.empty()) {
    Eigen::Vector3d color = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      color += w[k] * mesh.colors.row(mesh.faces(face, k)).cast<double>().transpose();
    return color;
  }
  Eigen::Vector2d uv = Eigen::Vector2d::Zero();
  for (int k = 0; k < 3; ++k) uv += w[k] * mesh.uvs.row(mesh.uv_faces(face, k)).transpose();
  return SampleTexture(pages[page_of_face[face]], uv);
}

TexturedMesh ReadTexturedMesh(const fs::path& mesh, const fs::path& texture) {
  TexturedMesh result;
  result.mesh = ReadMesh(mesh);
  if (!texture.empty()) {
    result.pages.push_back(ReadImage(texture, 3));
    result.page_of_face.assign(static_cast<std::size_t>(result.mesh.face_count()), 0);
  } else if (mesh.extension() == ".obj" && result.mesh.has_uvs()) {
    ReadPages(mesh, result);
  }
  CheckPages(mesh, result);
  return result;
}

}  // namespace keypose::bench
