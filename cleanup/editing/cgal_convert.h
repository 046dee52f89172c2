// Copies between the plain mesh arrays and CGAL's Surface_mesh. These are templates, so this header
// includes no CGAL header.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose::cleanup {

/// @tparam SurfaceMesh  CGAL::Surface_mesh<Point>
/// @param mesh  an oriented 2-manifold, possibly with boundary, without unused vertices
/// @return the same vertices and faces in the same order, without faces that CGAL cannot add
/// because the mesh would not be a manifold
template <class SurfaceMesh>
SurfaceMesh ToSurfaceMesh(const Mesh& mesh) {
  using Point = typename SurfaceMesh::Point;
  using VertexIndex = typename SurfaceMesh::Vertex_index;
  SurfaceMesh out;
  out.reserve(static_cast<unsigned>(mesh.points.rows()),
              static_cast<unsigned>(mesh.faces.rows() * 3 / 2 + 16),
              static_cast<unsigned>(mesh.faces.rows()));
  for (int v = 0; v < mesh.vertex_count(); ++v)
    out.add_vertex(Point(mesh.points(v, 0), mesh.points(v, 1), mesh.points(v, 2)));
  const auto at = [](int i) { return VertexIndex(static_cast<unsigned>(i)); };
  for (int f = 0; f < mesh.face_count(); ++f)
    out.add_face(at(mesh.faces(f, 0)), at(mesh.faces(f, 1)), at(mesh.faces(f, 2)));
  return out;
}

/// Positions and faces in CGAL's order, without removed and isolated vertices.
template <class SurfaceMesh>
Mesh FromSurfaceMesh(const SurfaceMesh& in) {
  std::vector<int> id(in.number_of_vertices() + in.number_of_removed_vertices(), -1);
  Mesh out;
  out.points.resize(in.number_of_vertices(), 3);
  int count = 0;
  for (const auto v : in.vertices()) {
    if (in.is_isolated(v)) continue;
    const auto& p = in.point(v);
    out.points.row(count) << p.x(), p.y(), p.z();
    id[v] = count++;
  }
  out.points.conservativeResize(count, 3);
  out.faces.resize(in.number_of_faces(), 3);
  int f = 0;
  for (const auto face : in.faces()) {
    const auto h = in.halfedge(face);
    out.faces.row(f++) << id[in.source(h)], id[in.target(h)], id[in.target(in.next(h))];
  }
  return out;
}

}  // namespace keypose::cleanup
