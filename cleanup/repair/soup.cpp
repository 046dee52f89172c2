#include "cleanup/repair/soup.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/manifoldness.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <set>
#include <vector>

#include "cleanup/editing/cgal_convert.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::cleanup {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using RepairMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Triangle = std::array<std::size_t, 3>;

// Vertices in the cells of a grid. Cells are much wider than the radius, so nearly all vertices
// only need to search their own cell.
class Grid {
 public:
  Grid(const PointsX3& points, double radius)
      : points_(points), radius_(radius), cell_(std::max(64 * radius, 1e-9)) {
    for (int v = 0; v < static_cast<int>(points.rows()); ++v)
      entries_.emplace_back(Key(points.row(v)), v);
    std::sort(entries_.begin(), entries_.end());
  }
  /// Calls visit(w) for all vertices within the radius of v, including v. The order only depends on
  /// the points.
  template <class Visit>
  void Near(int v, Visit visit) const {
    std::array<std::int64_t, 8> seen{};
    int count = 0;
    for (int corner = 0; corner < 8; ++corner) {
      Eigen::RowVector3d x = points_.row(v);
      for (int k = 0; k < 3; ++k) x[k] += corner >> k & 1 ? radius_ : -radius_;
      const std::int64_t key = Key(x);
      if (std::find(seen.begin(), seen.begin() + count, key) != seen.begin() + count) continue;
      seen[count++] = key;
      for (auto it = std::lower_bound(entries_.begin(), entries_.end(), std::pair(key, -1));
           it != entries_.end() && it->first == key; ++it)
        if ((points_.row(it->second) - points_.row(v)).norm() <= radius_) visit(it->second);
    }
  }

 private:
  // Different cells with the same key only cost time.
  std::int64_t Key(const Eigen::RowVector3d& x) const {
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k)
      key =
          (key ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x[k] / cell_)))) *
          0x9E3779B97F4A7C15ull;
    return static_cast<std::int64_t>(key);
  }
  const PointsX3& points_;
  double radius_, cell_;
  std::vector<std::pair<std::int64_t, int>> entries_;
};

// Each vertex is merged into the lowest vertex within the radius that is not merged itself, so
// chains of near points do not collapse into one.
std::vector<int> WeldTargets(const PointsX3& points, double radius) {
  std::vector<int> target(points.rows());
  std::iota(target.begin(), target.end(), 0);
  if (!(radius > 0)) return target;
  const Grid grid(points, radius);
  for (int v = 0; v < static_cast<int>(points.rows()); ++v) {
    if (target[v] != v) continue;
    grid.Near(v, [&](int w) {
      if (w > v && target[w] == w) target[w] = v;
    });
  }
  return target;
}

// Whether the faces of a vertex, in the order of `out` (directed edges that leave it), form one
// fan, open or closed.
bool OneFan(const FacesX3& faces, const int* out, int count) {
  const auto end = [&](int h) { return faces(h / 3, (h % 3 + 1) % 3); };
  const auto tip = [&](int h) { return faces(h / 3, (h % 3 + 2) % 3); };
  int start = 0;
  for (int i = 0; i < count; ++i) {
    bool follows = false;
    for (int j = 0; j < count; ++j) {
      if (j != i && end(out[j]) == end(out[i])) return false;
      follows |= tip(out[j]) == end(out[i]);
    }
    if (!follows) start = i;
  }
  int walked = 1;
  for (int at = start; walked <= count; ++walked) {
    int next = -1;
    for (int j = 0; j < count; ++j)
      if (end(out[j]) == tip(out[at])) next = j;
    if (next < 0 || next == start) break;
    at = next;
  }
  return walked == count;
}

// An oriented 2-manifold does not need the polygon soup tools, which take a minute for millions of
// faces.
bool IsOrientedManifold(int vertices, const FacesX3& faces) {
  // faces at a vertex; beyond this the search for the fan is slower than the tools
  constexpr int kMostFaces = 100;
  std::vector<int> begin(vertices + 1, 0), out(3 * faces.rows());
  for (int i = 0; i < std::ssize(out); ++i) ++begin[faces(i / 3, i % 3) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<int> at(begin.begin(), begin.end() - 1);
  for (int i = 0; i < std::ssize(out); ++i) out[at[faces(i / 3, i % 3)]++] = i;
  for (int v = 0; v < vertices; ++v) {
    const int count = begin[v + 1] - begin[v];
    if (count > kMostFaces || (count > 0 && !OneFan(faces, &out[begin[v]], count))) return false;
  }
  return true;
}

Mesh Compact(const Mesh& mesh, const std::vector<int>& target) {
  std::vector<int> id(mesh.vertex_count(), -1);
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) id[target[mesh.faces(f, k)]] = 0;
  Mesh out;
  out.points.resize(mesh.vertex_count(), 3);
  int count = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (id[v] == 0) {
      id[v] = count;
      out.points.row(count++) = mesh.points.row(v);
    }
  out.points.conservativeResize(count, 3);
  out.faces.resize(mesh.face_count(), 3);
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) out.faces(f, k) = id[target[mesh.faces(f, k)]];
  return out;
}

bool HasRepeatedCorner(const FacesX3& faces) {
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    if (faces(f, 0) == faces(f, 1) || faces(f, 1) == faces(f, 2) || faces(f, 2) == faces(f, 0))
      return true;
  return false;
}

std::vector<Triangle> DistinctTriangles(const FacesX3& faces, const std::vector<int>& target) {
  std::vector<Triangle> out;
  std::set<Triangle> seen;
  for (int f = 0; f < static_cast<int>(faces.rows()); ++f) {
    const Triangle t = {static_cast<std::size_t>(target[faces(f, 0)]),
                        static_cast<std::size_t>(target[faces(f, 1)]),
                        static_cast<std::size_t>(target[faces(f, 2)])};
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    Triangle key = t;
    std::sort(key.begin(), key.end());
    if (seen.insert(key).second) out.push_back(t);
  }
  return out;
}

/// Two corners of the first face that were merged into one.
[[noreturn]] void ThrowNoTriangle(const FacesX3& faces, const std::vector<int>& target) {
  int k = 0;
  while (k < 2 && target[faces(0, k)] != target[faces(0, k + 1)]) ++k;
  throw InputError(
      "cleanup: every face has two corners at the same place, such as face 0 with its vertices " +
      std::to_string(faces(0, k)) + " and " + std::to_string(faces(0, (k + 1) % 3)) +
      "; there is no surface to repair");
}

}  // namespace

SoupResult OrientedManifold(const Mesh& soup, double weld_radius) {
  SoupResult result;
  const std::vector<int> target = WeldTargets(soup.points, weld_radius);
  for (int v = 0; v < soup.vertex_count(); ++v) result.merged_vertices += target[v] != v;
  Mesh welded = Compact(soup, target);
  if (!HasRepeatedCorner(welded.faces) && IsOrientedManifold(welded.vertex_count(), welded.faces)) {
    result.mesh = std::move(welded);
    return result;
  }
  std::vector<Triangle> triangles = DistinctTriangles(soup.faces, target);
  result.dropped_faces = soup.face_count() - SizeOf(triangles);
  if (triangles.empty()) ThrowNoTriangle(soup.faces, target);

  std::vector<Kernel::Point_3> points;
  points.reserve(soup.points.rows());
  for (int v = 0; v < soup.vertex_count(); ++v)
    points.emplace_back(soup.points(v, 0), soup.points(v, 1), soup.points(v, 2));
  PMP::orient_polygon_soup(points, triangles);
  RepairMesh mesh;
  PMP::polygon_soup_to_polygon_mesh(points, triangles, mesh);
  result.mesh = FromSurfaceMesh(mesh);
  return result;
}

Mesh Stitched(const Mesh& manifold) {
  RepairMesh mesh = ToSurfaceMesh<RepairMesh>(manifold);
  PMP::stitch_borders(mesh);
  PMP::duplicate_non_manifold_vertices(mesh);
  return FromSurfaceMesh(mesh);
}

}  // namespace keypose::cleanup
