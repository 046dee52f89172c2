#include "core/io/meshes/ply_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "core/io/meshes/ply_io.h"
#include "core/io/meshes/polygon_fan.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {
namespace fs = std::filesystem;

namespace {

PointsX3 ColumnsToPoints(const PlyElement& element, const std::array<const char*, 3>& names) {
  PointsX3 points(static_cast<Eigen::Index>(element.count), 3);
  for (int k = 0; k < 3; ++k) {
    const auto& column = element.scalars.at(names[k]);
    for (std::size_t i = 0; i < column.size(); ++i)
      points(static_cast<Eigen::Index>(i), k) = column[i];
  }
  return points;
}

ColorsX3 ColumnsToColors(const PlyElement& element) {
  const std::array<const char*, 3> names{"red", "green", "blue"};
  ColorsX3 colors(static_cast<Eigen::Index>(element.count), 3);
  for (int k = 0; k < 3; ++k) {
    const auto& column = element.scalars.at(names[k]);
    for (std::size_t i = 0; i < column.size(); ++i)
      colors(static_cast<Eigen::Index>(i), k) = static_cast<std::uint8_t>(
          std::lround(std::isfinite(column[i]) ? std::clamp(column[i], 0.0, 255.0) : 0.0));
  }
  return colors;
}

const PlyElement& VertexElement(const PlyTable& table, const fs::path& path) {
  const auto it = table.find("vertex");
  if (it == table.end() || !it->second.Has("x") || !it->second.Has("y") || !it->second.Has("z"))
    throw InputError(path.string() + ": the PLY file has no vertices with x, y and z");
  return it->second;
}

template <class Target>
void ReadVertexExtras(const PlyElement& vertex, Target& target) {
  if (vertex.Has("nx") && vertex.Has("ny") && vertex.Has("nz"))
    target.normals = ColumnsToPoints(vertex, {"nx", "ny", "nz"});
  if (vertex.Has("red") && vertex.Has("green") && vertex.Has("blue"))
    target.colors = ColumnsToColors(vertex);
}

/// Texture coordinates of the faces' corners (MeshLab's list `texcoord`). Equal pairs become one
/// entry. Nothing where a face has another number of them than of corners.
void ReadCornerUvs(const PlyList& corners, const PlyElement& face, const fs::path& path,
                   Mesh& mesh) {
  const auto it = face.lists.find("texcoord");
  if (it == face.lists.end()) return;
  const PlyList& list = it->second;
  for (std::size_t i = 0; i < corners.offsets.size(); ++i)
    if (list.offsets[i] != 2 * corners.offsets[i]) return;
  std::map<std::pair<double, double>, int> ids;
  std::vector<Eigen::Vector2d> uvs;
  std::vector<int> uv_of_corner(corners.values.size());
  for (std::size_t c = 0; c < uv_of_corner.size(); ++c) {
    const double u = list.values[2 * c], v = list.values[2 * c + 1];
    const auto [entry, is_new] = ids.emplace(std::pair(u, v), SizeOf(uvs));
    if (is_new) uvs.emplace_back(u, v);
    uv_of_corner[c] = entry->second;
  }
  Fan fan(path, std::ssize(uvs));
  for (std::size_t i = 0; i + 1 < corners.offsets.size(); ++i)
    fan.Add(uv_of_corner.data() + corners.offsets[i], corners.offsets[i + 1] - corners.offsets[i]);
  mesh.uv_faces = fan.Take();
  mesh.uvs.resize(std::ssize(uvs), 2);
  for (std::size_t i = 0; i < uvs.size(); ++i) mesh.uvs.row(i) = uvs[i];
}

/// Texture coordinates of the vertices, which are doubled at seams then: Blender writes `s t`,
/// MeshLab `texture_u texture_v`.
void ReadVertexUvs(const PlyElement& vertex, Mesh& mesh) {
  for (const auto& [u, v] : {std::pair{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}}) {
    if (!vertex.Has(u) || !vertex.Has(v)) continue;
    mesh.uvs.resize(mesh.points.rows(), 2);
    for (Eigen::Index i = 0; i < mesh.uvs.rows(); ++i)
      mesh.uvs.row(i) << vertex.scalars.at(u)[i], vertex.scalars.at(v)[i];
    mesh.uv_faces = mesh.faces;
    return;
  }
}

}  // namespace

Mesh ReadPlyMesh(const fs::path& path) {
  const PlyTable table = ReadPly(path);
  const PlyElement& vertex = VertexElement(table, path);
  Mesh mesh;
  mesh.points = ColumnsToPoints(vertex, {"x", "y", "z"});
  ReadVertexExtras(vertex, mesh);
  const auto face = table.find("face");
  if (face == table.end()) return mesh;
  for (const char* name : {"vertex_indices", "vertex_index"}) {
    const auto it = face->second.lists.find(name);
    if (it == face->second.lists.end()) continue;
    Fan fan(path, mesh.points.rows());
    const PlyList& list = it->second;
    for (std::size_t i = 0; i + 1 < list.offsets.size(); ++i)
      fan.Add(list.values.data() + list.offsets[i], list.offsets[i + 1] - list.offsets[i]);
    mesh.faces = fan.Take();
    ReadCornerUvs(list, face->second, path, mesh);
    if (!mesh.has_uvs()) ReadVertexUvs(vertex, mesh);
    break;
  }
  return mesh;
}

PointCloud ReadPlyCloud(const fs::path& path) {
  const PlyTable table = ReadPly(path);
  const PlyElement& vertex = VertexElement(table, path);
  PointCloud cloud;
  cloud.points = ColumnsToPoints(vertex, {"x", "y", "z"});
  ReadVertexExtras(vertex, cloud);
  if (vertex.Has("confidence")) {
    const auto& column = vertex.scalars.at("confidence");
    cloud.confidence =
        Eigen::Map<const Eigen::VectorXd>(column.data(), std::ssize(column)).cast<float>();
  }
  return cloud;
}

}  // namespace keypose
