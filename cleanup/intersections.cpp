#include "cleanup/intersections.h"

// Smoothing first costs minutes on a tangle and hole filling resolves the same places.
#define CGAL_PMP_REMOVE_SELF_INTERSECTIONS_NO_SMOOTHING 1
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "cleanup/cgal_convert.h"

namespace keypose::cleanup {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Face = SurfaceMesh::Face_index;

}  // namespace

bool SelfIntersects(const Mesh& mesh) { return PMP::does_self_intersect<CGAL::Sequential_tag>(ToSurfaceMesh<SurfaceMesh>(mesh)); }

std::vector<int> IntersectingFaces(const Mesh& mesh, int* pair_count) {
  std::vector<std::pair<Face, Face>> pairs;
  PMP::self_intersections<CGAL::Sequential_tag>(ToSurfaceMesh<SurfaceMesh>(mesh), std::back_inserter(pairs));
  std::vector<int> faces;
  for (const auto& [a, b] : pairs) {
    faces.push_back(static_cast<int>(a.idx()));
    faces.push_back(static_cast<int>(b.idx()));
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  if (pair_count) *pair_count = static_cast<int>(pairs.size());
  return faces;
}

Mesh WithoutIntersections(const Mesh& closed, int rounds) {
  SurfaceMesh mesh = ToSurfaceMesh<SurfaceMesh>(closed);
  PMP::experimental::remove_self_intersections(mesh, CGAL::parameters::number_of_iterations(rounds).preserve_genus(false));
  mesh.collect_garbage();
  return FromSurfaceMesh(mesh);
}

}  // namespace keypose::cleanup
