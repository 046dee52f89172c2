#include "cleanup/soup.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/manifoldness.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <set>
#include <vector>

#include "cleanup/cgal_convert.h"
#include "core/errors.h"
#include "core/kd_tree.h"

namespace keypose::cleanup {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Triangle = std::array<std::size_t, 3>;

// Each vertex goes to the lowest vertex within the radius that stands for itself, so chains of near points do not run away.
std::vector<int> WeldTargets(const PointsX3& points, double radius) {
  std::vector<int> target(points.rows());
  std::iota(target.begin(), target.end(), 0);
  const KdTree tree(points);
  for (int v = 0; v < static_cast<int>(points.rows()); ++v) {
    if (target[v] != v) continue;
    for (const KdTree::Neighbor& near : tree.Within(points.row(v).transpose(), radius)) {
      if (near.index > v && target[near.index] == near.index) target[near.index] = v;
    }
  }
  return target;
}

std::vector<Triangle> DistinctTriangles(const FacesX3& faces, const std::vector<int>& target) {
  std::vector<Triangle> out;
  std::set<Triangle> seen;
  for (int f = 0; f < static_cast<int>(faces.rows()); ++f) {
    const Triangle t = {static_cast<std::size_t>(target[faces(f, 0)]), static_cast<std::size_t>(target[faces(f, 1)]),
                        static_cast<std::size_t>(target[faces(f, 2)])};
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    Triangle key = t;
    std::sort(key.begin(), key.end());
    if (seen.insert(key).second) out.push_back(t);
  }
  return out;
}

}  // namespace

SoupResult OrientedManifold(const Mesh& soup, double weld_radius) {
  SoupResult result;
  const std::vector<int> target = WeldTargets(soup.points, weld_radius);
  for (int v = 0; v < soup.vertex_count(); ++v) result.merged_vertices += target[v] != v;
  std::vector<Triangle> triangles = DistinctTriangles(soup.faces, target);
  result.dropped_faces = soup.face_count() - static_cast<int>(triangles.size());
  if (triangles.empty()) throw InputError("cleanup: every face has two corners at the same place; there is no surface to repair");

  std::vector<Kernel::Point_3> points;
  points.reserve(soup.points.rows());
  for (int v = 0; v < soup.vertex_count(); ++v) points.emplace_back(soup.points(v, 0), soup.points(v, 1), soup.points(v, 2));
  PMP::orient_polygon_soup(points, triangles);
  SurfaceMesh mesh;
  PMP::polygon_soup_to_polygon_mesh(points, triangles, mesh);
  result.mesh = FromSurfaceMesh(mesh);
  return result;
}

Mesh Stitched(const Mesh& manifold) {
  SurfaceMesh mesh = ToSurfaceMesh<SurfaceMesh>(manifold);
  PMP::stitch_borders(mesh);
  PMP::duplicate_non_manifold_vertices(mesh);
  return FromSurfaceMesh(mesh);
}

}  // namespace keypose::cleanup
