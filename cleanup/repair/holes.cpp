#include "cleanup/repair/holes.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include "core/numbers/ordered_memory.h"

// CGAL traverses the cells of a triangulation by address. Of two triangles that fill a rim equally
// well, it takes the one that it finds first.
#undef CGAL_ALLOCATOR
#define CGAL_ALLOCATOR(T) keypose::OrderedAllocator<T>
#include <CGAL/Compact_container.h>
#undef CGAL_ALLOCATOR
#define CGAL_ALLOCATOR(T) std::allocator<T>
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Triangulation_data_structure_3.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "cleanup/editing/cgal_convert.h"
#include "core/surfaces/geometry.h"

namespace keypose::cleanup {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using RepairMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Halfedge = RepairMesh::Halfedge_index;
using Face = RepairMesh::Face_index;
using Vertex = RepairMesh::Vertex_index;

using Cells = CGAL::Triangulation_data_structure_3<>::Cell_range;
static_assert(std::is_same_v<Cells::allocator_type, OrderedAllocator<Cells::value_type>>,
              "CGAL/Compact_container.h must be included with the allocator above");

constexpr double kFlatRim = 1e-5;  // of the rim's extent
// A quarter of the shortest side of the rim's box, which is 0 for a level rim.
constexpr double kAsCgalSets = -1;
// rim vertices up to which the O(n^3) search is affordable (about a second)
constexpr std::size_t kCubicLimit = 400;

// many times the memory of a triangulation of the rim; only used pages take memory
constexpr std::size_t kLeastBytes = 1 << 20, kBytesAVertex = 16 << 10;
// A rim can have a tetrahedron for every second pair of its vertices.
constexpr std::size_t kBytesAPair = 64, kMostBytes = 1 << 30;

struct Rim {
  std::size_t vertices = 0;
  double extent = 0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  bool flat = false;
  bool apart = false;  // see ApartInPlanarView
};

// Whether all points lie in one plane, which only happens after a cut.
bool Flat(const std::vector<Eigen::Vector3d>& rim, const Eigen::Vector3d& center,
          double tolerance) {
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& x : rim) spread += (x - center) * (x - center).transpose();
  const Eigen::Vector3d normal =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
  return std::all_of(rim.begin(), rim.end(), [&](const Eigen::Vector3d& x) {
    return std::abs(normal.dot(x - center)) <= tolerance;
  });
}

// The direction in which CGAL's planar triangulation projects a rim: the mean of the normals of its
// fan, each flipped to one half of the sphere.
Eigen::Vector3d PlanarView(const std::vector<Eigen::Vector3d>& rim) {
  const auto point = [&](std::size_t i) {
    return Kernel::Point_3(rim[i].x(), rim[i].y(), rim[i].z());
  };
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 1; i + 1 < rim.size(); ++i) {
    if (CGAL::collinear(point(0), point(i), point(i + 1))) continue;
    const Kernel::Vector_3 across = CGAL::normal(point(0), point(i), point(i + 1));
    const Eigen::Vector3d normal(across.x(), across.y(), across.z());
    const bool kept = std::tuple(normal.x(), normal.y(), normal.z()) > std::tuple(0.0, 0.0, 0.0);
    sum += kept ? normal : Eigen::Vector3d(-normal);
  }
  return sum;
}

Rim Measure(const RepairMesh& mesh, Halfedge border) {
  Rim rim;
  Eigen::AlignedBox3d box;
  std::vector<Eigen::Vector3d> points;
  Halfedge h = border;
  do {
    const auto& p = mesh.point(mesh.target(h));
    const Eigen::Vector3d x(p.x(), p.y(), p.z());
    box.extend(x);
    rim.center += x;
    points.push_back(x);
    ++rim.vertices;
    h = mesh.next(h);
  } while (h != border);
  rim.center /= static_cast<double>(rim.vertices);
  rim.extent = box.diagonal().norm();
  rim.flat = Flat(points, rim.center, kFlatRim * rim.extent);
  rim.apart = ApartInPlanarView(points, rim.extent);
  return rim;
}

// Always possible on a simple rim. The next strategy removes the intersections that it may cause.
void FillByFan(RepairMesh& mesh, Halfedge border, const Eigen::Vector3d& center) {
  std::vector<Halfedge> rim;
  Halfedge h = border;
  do {
    rim.push_back(h);
    h = mesh.next(h);
  } while (h != border);
  std::vector<std::pair<Vertex, Vertex>> edges;
  for (const Halfedge e : rim) edges.emplace_back(mesh.source(e), mesh.target(e));
  const Vertex hub = mesh.add_vertex(Kernel::Point_3(center.x(), center.y(), center.z()));
  for (const auto& [a, b] : edges) mesh.add_face(a, b, hub);
}

// Returns true when a triangulation was found; otherwise the mesh does not change.
bool FillSmoothly(RepairMesh& mesh, Halfedge border, const Rim& rim, bool large) {
  std::vector<Face> faces;
  std::vector<Vertex> vertices;
  const OrderedMemory memory(std::min(kMostBytes, kLeastBytes + kBytesAVertex * rim.vertices +
                                                      kBytesAPair * rim.vertices * rim.vertices));
  const bool no_cubic = rim.vertices > kCubicLimit;
  PMP::triangulate_hole(
      mesh, border, std::back_inserter(faces),
      CGAL::parameters::use_2d_constrained_delaunay_triangulation(large && rim.apart)
          .threshold_distance(rim.flat ? kFlatRim * rim.extent : kAsCgalSets)
          .do_not_use_cubic_algorithm(no_cubic));
  if (faces.empty()) return false;
  if (rim.vertices <= 4) return true;
  std::vector<Face> refined = faces;
  PMP::refine(mesh, faces, std::back_inserter(refined), std::back_inserter(vertices));
  if (!vertices.empty())
    PMP::fair(mesh, vertices, CGAL::parameters::fairing_continuity(large ? 0 : 1));
  return true;
}

}  // namespace

// CGAL's planar triangulation has crashed on other rims (CGAL 5.5).
bool ApartInPlanarView(const std::vector<Eigen::Vector3d>& rim, double extent) {
  const double cell = 1e-9 * extent;
  const Eigen::Vector3d view = PlanarView(rim);
  if (!(view.norm() > 0) || !(cell > 0)) return false;
  const Eigen::Vector3d across = view.unitOrthogonal(), up = view.normalized().cross(across);
  std::set<std::pair<double, double>> taken;
  for (const Eigen::Vector3d& p : rim) {
    const Eigen::Vector3d x = p - rim[0];
    const double u = std::floor(x.dot(across) / cell), v = std::floor(x.dot(up) / cell);
    for (int k = 0; k < 9; ++k)
      if (taken.count({u + k % 3 - 1, v + k / 3 - 1}) > 0) return false;
    taken.insert({u, v});
  }
  return true;
}

HolesResult FillHoles(const Mesh& manifold, Progress* progress, double large_hole) {
  HolesResult result;
  RepairMesh mesh = ToSurfaceMesh<RepairMesh>(manifold);
  const double diagonal = BoundingDiagonal(manifold.points);
  std::vector<Halfedge> borders;
  PMP::extract_boundary_cycles(mesh, std::back_inserter(borders));
  for (std::size_t i = 0; i < borders.size(); ++i) {
    ReportProgress(progress, static_cast<double>(i) / static_cast<double>(borders.size()),
                   "filling holes");
    const Rim rim = Measure(mesh, borders[i]);
    result.largest_over_diag = std::max(result.largest_over_diag, rim.extent / diagonal);
    if (!FillSmoothly(mesh, borders[i], rim, rim.flat || rim.extent > large_hole * diagonal)) {
      FillByFan(mesh, borders[i], rim.center);
      ++result.fanned;
    }
    ++result.filled;
  }
  result.mesh = FromSurfaceMesh(mesh);
  return result;
}

}  // namespace keypose::cleanup
