#include "core/io/meshes/mesh_look.h"

#include <fmt/format.h>

#include <fstream>
#include <set>
#include <string_view>

#include "core/io/text/files.h"

namespace keypose {
namespace {

/// Materials of an OBJ that have faces, in the order of their names.
std::set<std::string> MaterialsOf(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::set<std::string> used;
  std::string material;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("ply") || line.starts_with("glTF")) return {};
    const auto is = [&line](std::string_view word) {
      return line.starts_with(word) && line.find_first_of(" \t") == word.size();
    };
    if (is("usemtl")) material = line.substr(7, line.find_last_not_of("\r\t ") - 6);
    if (is("f")) used.insert(material);
  }
  return used;
}

std::string NamesOf(const std::set<std::string>& names) {
  constexpr std::size_t kNamed = 3;
  std::string text;
  std::size_t count = 0;
  for (const std::string& name : names) {
    if (count == kNamed) return text + ", ...";
    text += (count++ ? ", " : "") + (name.empty() ? std::string("none") : name);
  }
  return text;
}

/// Texture programs put borders exactly at 0 and 1.
constexpr double kBorder = 1e-4;

bool LeavesSquare(const Mesh& mesh, Eigen::Index face) {
  for (int k = 0; k < 3; ++k) {
    const auto uv = mesh.uvs.row(mesh.uv_faces(face, k));
    if (uv.minCoeff() < -kBorder || uv.maxCoeff() > 1 + kBorder) return true;
  }
  return false;
}

}  // namespace

std::vector<std::string> LookWarnings(const std::filesystem::path& path, const Mesh& mesh) {
  std::vector<std::string> warnings;
  if (!mesh.has_uvs()) return warnings;
  const std::string file = PrintableName(path);
  const std::set<std::string> materials = MaterialsOf(path);
  if (materials.size() > 1)
    warnings.push_back(fmt::format(
        "{} has {} materials ({}), but what is exported has one, with one texture: bake them into "
        "one layout and one texture in your modelling program first",
        file, materials.size(), NamesOf(materials)));
  int outside = 0, without = 0;
  for (Eigen::Index f = 0; f < mesh.uv_faces.rows(); ++f) {
    const auto uvs = mesh.uv_faces.row(f);
    outside += LeavesSquare(mesh, f);
    without += uvs[0] == uvs[1] && uvs[1] == uvs[2];
  }
  if (outside > 0)
    warnings.push_back(fmt::format(
        "{} of {} faces of {} lie outside of the texture (UDIM tiles, or a texture that repeats): "
        "programs will show them in wrong colours; bake them into one square first",
        outside, mesh.face_count(), file));
  if (without > 0)
    warnings.push_back(
        fmt::format("{} of {} faces of {} have no texture coordinates: each has one colour",
                    without, mesh.face_count(), file));
  return warnings;
}

}  // namespace keypose
