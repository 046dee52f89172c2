#include "core/io/meshes/polygon_mesh.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/obj_file.h"
#include "core/values/same_faces.h"

namespace keypose {
namespace {

/// Gives polygons the triangles that they have in another pose.
class Recutter {
 public:
  Recutter(const PolygonMesh& read, const FacesX3& wanted)
      : mesh_(read.mesh), polygons_(read.polygons), wanted_(wanted), uv_faces_(mesh_.uv_faces) {}

  /// @return whether the triangles are of these polygons, in their order
  bool Recut() {
    if (wanted_.rows() != mesh_.faces.rows() || polygons_.sizes.empty()) return false;
    Eigen::Index face = 0;
    const int* corners = polygons_.corners.data();
    for (const int size : polygons_.sizes) {
      const Eigen::Index count = size - 2;
      if (wanted_.middleRows(face, count) != mesh_.faces.middleRows(face, count)) {
        if (!Cover(corners, size, face)) return false;
        if (mesh_.has_uvs()) TakeUvs(face, count);
      }
      face += count;
      corners += size;
    }
    return true;
  }

  /// Empty: of a vertex that a polygon has twice it is not known which place in the texture is
  /// whose.
  FacesX3 TakeUvFaces() && { return unclear_ ? FacesX3(0, 3) : std::move(uv_faces_); }

 private:
  /// Whether the triangles have only the polygon's corners, and what remains of their edges, where
  /// those that two share cancel out, are the polygon's.
  bool Cover(const int* corners, int size, Eigen::Index face) const {
    std::map<std::pair<int, int>, int> edges;
    const auto count = [&edges](int from, int to, int times) {
      if (from < to) edges[{from, to}] += times;
      if (to < from) edges[{to, from}] -= times;
    };
    for (int k = 0; k < size; ++k) count(corners[k], corners[(k + 1) % size], -1);
    for (Eigen::Index t = face; t < face + size - 2; ++t)
      for (int k = 0; k < 3; ++k) {
        if (std::find(corners, corners + size, wanted_(t, k)) == corners + size) return false;
        count(wanted_(t, k), wanted_(t, (k + 1) % 3), 1);
      }
    for (const auto& [edge, times] : edges)
      if (times != 0) return false;
    return true;
  }

  void TakeUvs(Eigen::Index face, Eigen::Index count) {
    std::map<int, int> uv_of_vertex;
    for (Eigen::Index t = face; t < face + count; ++t)
      for (int k = 0; k < 3; ++k) {
        const int uv = mesh_.uv_faces(t, k);
        unclear_ |= uv_of_vertex.emplace(mesh_.faces(t, k), uv).first->second != uv;
      }
    for (Eigen::Index t = face; t < face + count; ++t)
      for (int k = 0; k < 3; ++k) uv_faces_(t, k) = uv_of_vertex[wanted_(t, k)];
  }

  const Mesh& mesh_;
  const Polygons& polygons_;
  const FacesX3& wanted_;
  FacesX3 uv_faces_;
  bool unclear_ = false;
};

}  // namespace

PolygonMesh ReadPolygonMesh(const std::filesystem::path& path) {
  if (MeshKindOf(path) != MeshKind::kObj) return {ReadMesh(path), {}};
  ObjFile file = ReadObj(path);
  return {std::move(file.mesh), std::move(file.polygons)};
}

Mesh ReadMeshCutAs(const std::filesystem::path& path, const Mesh& first) {
  PolygonMesh read = ReadPolygonMesh(path);
  Mesh& mesh = read.mesh;
  if (mesh.points.rows() != first.points.rows() || SameFaces(mesh.faces, first.faces))
    return std::move(mesh);
  Recutter recutter(read, first.faces);
  if (!recutter.Recut()) return std::move(mesh);
  mesh.faces = first.faces;
  mesh.uv_faces = std::move(recutter).TakeUvFaces();
  if (mesh.uv_faces.rows() == 0) mesh.uvs.resize(0, 2);
  return std::move(mesh);
}

}  // namespace keypose
