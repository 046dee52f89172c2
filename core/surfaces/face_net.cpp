#include "core/surfaces/face_net.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

class NetBuilder {
 public:
  NetBuilder(const Mesh& mesh, const Polygons& polygons) : mesh_(mesh), polygons_(polygons) {}

  FaceNet Build() {
    RequireCounts();
    for (int p = 0; p < SizeOf(polygons_.sizes); ++p) {
      const int size = polygons_.sizes[p];
      if (size == 3)
        AddTriangleAt(p);
      else
        AddPolygon(p);
      first_corner_ += size;
      first_face_ += size - 2;
    }
    return std::move(net_);
  }

 private:
  void RequireCounts() const {
    std::int64_t triangles = 0, corners = 0;
    for (const int size : polygons_.sizes) {
      if (size < 3) throw InputError("a polygon has fewer than three corners");
      triangles += size - 2;
      corners += size;
    }
    if (triangles != mesh_.face_count() || corners != SizeOf(polygons_.corners))
      throw InputError(fmt::format(
          "the polygons are those of another mesh: they are {} triangles, and the mesh has {}",
          triangles, mesh_.face_count()));
  }

  [[noreturn]] static void Refuse(int polygon) {
    throw InputError(
        fmt::format("the polygons are those of another mesh: number {} (from 0) has other corners "
                    "than its triangles",
                    polygon));
  }

  void AddCorner(int vertex, int face, int corner) {
    net_.vertices.push_back(vertex);
    if (mesh_.has_uvs()) net_.uvs.push_back(mesh_.uv_faces(face, corner));
  }

  void AddTriangle(int face) {
    net_.sizes.push_back(3);
    for (int k = 0; k < 3; ++k) AddCorner(mesh_.faces(face, k), face, k);
  }

  /// One that was a triangle in the file, whose first corner may have moved.
  void AddTriangleAt(int polygon) {
    const int* corners = &polygons_.corners[first_corner_];
    for (int turn = 0; turn < 3; ++turn) {
      bool same = true;
      for (int k = 0; k < 3; ++k) same &= mesh_.faces(first_face_, (turn + k) % 3) == corners[k];
      if (!same) continue;
      net_.sizes.push_back(3);
      for (int k = 0; k < 3; ++k) AddCorner(corners[k], first_face_, (turn + k) % 3);
      return;
    }
    Refuse(polygon);
  }

  void AddPolygon(int polygon) {
    const int size = polygons_.sizes[polygon];
    FindPlaces(size);
    const bool twice =
        std::adjacent_find(places_.begin(), places_.end(), [](const auto& a, const auto& b) {
          return a.first == b.first;
        }) != places_.end();
    if (!twice) RequireEdges(polygon);
    if (twice || !FindUvs(size)) {
      ++net_.taken_apart;
      for (int t = 0; t < size - 2; ++t) AddTriangle(first_face_ + t);
      return;
    }
    net_.sizes.push_back(size);
    const auto begin = polygons_.corners.begin() + first_corner_;
    net_.vertices.insert(net_.vertices.end(), begin, begin + size);
    if (mesh_.has_uvs()) net_.uvs.insert(net_.uvs.end(), uvs_.begin(), uvs_.end());
  }

  /// Where each vertex stands in the polygon, by vertex.
  void FindPlaces(int size) {
    places_.clear();
    for (int k = 0; k < size; ++k) places_.emplace_back(polygons_.corners[first_corner_ + k], k);
    std::sort(places_.begin(), places_.end());
  }

  /// -1: it is no corner of the polygon.
  int PlaceOf(int vertex) const {
    const auto found = std::lower_bound(places_.begin(), places_.end(), std::pair(vertex, 0));
    return found != places_.end() && found->first == vertex ? found->second : -1;
  }

  /// A polygon of n corners has n edges; n - 2 triangles that have all of them cover it.
  void RequireEdges(int polygon) const {
    const int size = polygons_.sizes[polygon];
    int edges = 0;
    for (int t = 0; t < size - 2; ++t)
      for (int k = 0; k < 3; ++k) {
        const int from = PlaceOf(mesh_.faces(first_face_ + t, k)),
                  to = PlaceOf(mesh_.faces(first_face_ + t, (k + 1) % 3));
        if (from < 0 || to < 0) Refuse(polygon);
        edges += to == (from + 1) % size;
      }
    if (edges != size) Refuse(polygon);
  }

  /// @return whether each corner has one texture coordinate in all of its triangles
  bool FindUvs(int size) {
    if (!mesh_.has_uvs()) return true;
    uvs_.assign(static_cast<std::size_t>(size), -1);
    for (int t = 0; t < size - 2; ++t)
      for (int k = 0; k < 3; ++k) {
        int& uv = uvs_[PlaceOf(mesh_.faces(first_face_ + t, k))];
        const int here = mesh_.uv_faces(first_face_ + t, k);
        if (uv >= 0 && mesh_.uvs.row(uv) != mesh_.uvs.row(here)) return false;
        if (uv < 0) uv = here;
      }
    return true;
  }

  const Mesh& mesh_;
  const Polygons& polygons_;
  FaceNet net_;
  int first_corner_ = 0, first_face_ = 0;
  std::vector<std::pair<int, int>> places_;
  std::vector<int> uvs_;
};

FaceNet TrianglesOf(const Mesh& mesh) {
  FaceNet net;
  net.sizes.assign(static_cast<std::size_t>(mesh.face_count()), 3);
  net.vertices.assign(mesh.faces.data(), mesh.faces.data() + mesh.faces.size());
  if (mesh.has_uvs())
    net.uvs.assign(mesh.uv_faces.data(), mesh.uv_faces.data() + mesh.uv_faces.size());
  return net;
}

}  // namespace

FaceNet NetOf(const Mesh& mesh, const Polygons& polygons) {
  return polygons.sizes.empty() ? TrianglesOf(mesh) : NetBuilder(mesh, polygons).Build();
}

}  // namespace keypose
