#include "core/surfaces/geometry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <unordered_map>

#include "core/values/union_find.h"

namespace keypose {
namespace {

Eigen::Vector3d FaceCross(const PointsX3& points, const FacesX3& faces, Eigen::Index f) {
  const Eigen::Vector3d a = points.row(faces(f, 0)), b = points.row(faces(f, 1)),
                        c = points.row(faces(f, 2));
  return (b - a).cross(c - a);
}

std::uint64_t DirectedKey(int a, int b) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(a)) << 32) |
         static_cast<std::uint32_t>(b);
}

/// The edges of all faces, grouped by their lower vertex: other[offset[a] .. offset[a + 1]) are the
/// higher vertices, sorted, one entry for each face.
struct Sides {
  std::vector<int> offset, other;
};

Sides SidesOf(int vertex_count, const FacesX3& faces) {
  Sides sides;
  sides.offset.assign(static_cast<std::size_t>(vertex_count) + 1, 0);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) ++sides.offset[std::min(faces(f, k), faces(f, (k + 1) % 3)) + 1];
  std::partial_sum(sides.offset.begin(), sides.offset.end(), sides.offset.begin());
  sides.other.resize(static_cast<std::size_t>(faces.size()));
  std::vector<int> next(sides.offset.begin(), sides.offset.end() - 1);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(faces(f, k), faces(f, (k + 1) % 3));
      sides.other[next[a]++] = b;
    }
  for (int a = 0; a < vertex_count; ++a)
    std::sort(sides.other.begin() + sides.offset[a], sides.other.begin() + sides.offset[a + 1]);
  return sides;
}

/// The number of occurrences of each directed edge.
std::unordered_map<std::uint64_t, int> DirectedEdgeCounts(const FacesX3& faces) {
  std::unordered_map<std::uint64_t, int> counts;
  counts.reserve(static_cast<std::size_t>(faces.rows()) * 4);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) ++counts[DirectedKey(faces(f, k), faces(f, (k + 1) % 3))];
  return counts;
}

int CountOf(const std::unordered_map<std::uint64_t, int>& counts, int a, int b) {
  const auto it = counts.find(DirectedKey(a, b));
  return it == counts.end() ? 0 : it->second;
}

int CountComponents(int vertex_count, const FacesX3& faces) {
  UnionFind parts(vertex_count);
  std::vector<char> used(static_cast<std::size_t>(vertex_count), 0);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    for (int k = 0; k < 3; ++k) used[faces(f, k)] = 1;
    parts.Join(faces(f, 0), faces(f, 1));
    parts.Join(faces(f, 1), faces(f, 2));
  }
  int components = 0;
  for (int v = 0; v < vertex_count; ++v) components += used[v] && parts.Find(v) == v;
  return components;
}

/// Vertices whose faces do not form exactly one closed fan, and vertices without a face.
void CountFans(int vertex_count, const FacesX3& faces, ClosedReport& report) {
  std::vector<std::vector<std::pair<int, int>>> link(static_cast<std::size_t>(vertex_count));
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      link[faces(f, k)].emplace_back(faces(f, (k + 1) % 3), faces(f, (k + 2) % 3));
  for (auto& arcs : link) {
    if (arcs.empty()) {
      ++report.unused_vertices;
      continue;
    }
    std::sort(arcs.begin(), arcs.end());
    const auto successor = [&](int from) {
      const auto it = std::lower_bound(arcs.begin(), arcs.end(), std::pair<int, int>(from, -1));
      return it != arcs.end() && it->first == from ? it->second : -1;
    };
    const int start = arcs.front().first;
    std::size_t steps = 0;
    int at = start;
    do {
      at = successor(at);
      ++steps;
    } while (at != -1 && at != start && steps <= arcs.size());
    report.bad_fans += !(at == start && steps == arcs.size());
  }
}

}  // namespace

double BoundingDiagonal(const PointsX3& points) {
  if (points.rows() == 0) return 0;
  return (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
}

Eigen::VectorXd FaceAreas(const PointsX3& points, const FacesX3& faces) {
  Eigen::VectorXd areas(faces.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    areas(f) = 0.5 * FaceCross(points, faces, f).norm();
  return areas;
}

Eigen::VectorXd VertexAreas(const PointsX3& points, const FacesX3& faces) {
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(points.rows());
  const Eigen::VectorXd of_faces = FaceAreas(points, faces);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) areas[faces(f, k)] += of_faces[f] / 3;
  return areas;
}

double SurfaceArea(const PointsX3& points, const FacesX3& faces) {
  return FaceAreas(points, faces).sum();
}

double SignedVolume(const PointsX3& points, const FacesX3& faces) {
  if (points.rows() == 0) return 0;
  // Relative to the centroid: far from the origin, cancellation would make the volume inaccurate.
  const Eigen::Vector3d center = points.colwise().mean();
  double volume = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const Eigen::Vector3d a = points.row(faces(f, 0)).transpose() - center,
                          b = points.row(faces(f, 1)).transpose() - center,
                          c = points.row(faces(f, 2)).transpose() - center;
    volume += a.dot(b.cross(c));
  }
  return volume / 6;
}

PointsX3 FaceNormals(const PointsX3& points, const FacesX3& faces) {
  PointsX3 normals(faces.rows(), 3);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const Eigen::Vector3d cross = FaceCross(points, faces, f);
    const double length = cross.norm();
    normals.row(f) = length > 0 ? Eigen::Vector3d(cross / length) : Eigen::Vector3d::Zero();
  }
  return normals;
}

PointsX3 VertexNormals(const PointsX3& points, const FacesX3& faces) {
  PointsX3 normals = PointsX3::Zero(points.rows(), 3);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const Eigen::Vector3d cross = FaceCross(points, faces, f);
    for (int k = 0; k < 3; ++k) normals.row(faces(f, k)) += cross;
  }
  for (Eigen::Index v = 0; v < normals.rows(); ++v) {
    const double length = normals.row(v).norm();
    if (length > 0) normals.row(v) /= length;
  }
  return normals;
}

std::vector<std::pair<int, int>> UndirectedEdges(const FacesX3& faces) {
  const Sides sides = SidesOf(faces.size() > 0 ? faces.maxCoeff() + 1 : 0, faces);
  std::vector<std::pair<int, int>> edges;
  edges.reserve(sides.other.size() / 2 + 1);
  for (int a = 0; a + 1 < std::ssize(sides.offset); ++a)
    for (int s = sides.offset[a]; s < sides.offset[a + 1]; ++s)
      if (s == sides.offset[a] || sides.other[s] != sides.other[s - 1])
        edges.emplace_back(a, sides.other[s]);
  return edges;
}

std::vector<char> BoundaryVertices(int vertex_count, const FacesX3& faces) {
  std::vector<char> boundary(static_cast<std::size_t>(vertex_count), 0);
  const Sides sides = SidesOf(vertex_count, faces);
  for (int a = 0; a < vertex_count; ++a)
    for (int s = sides.offset[a], run = s; s < sides.offset[a + 1]; s = run) {
      while (run < sides.offset[a + 1] && sides.other[run] == sides.other[s]) ++run;
      if (run - s != 2 && sides.other[s] != a) boundary[a] = boundary[sides.other[s]] = 1;
    }
  return boundary;
}

ClosedReport CheckClosed(const Mesh& mesh) {
  ClosedReport report;
  report.finite = mesh.points.allFinite();
  const auto counts = DirectedEdgeCounts(mesh.faces);
  for (const auto& [key, count] : counts) {
    const int a = static_cast<int>(key >> 32), b = static_cast<int>(key & 0xffffffffu);
    report.bad_edges += count != 1 || CountOf(counts, b, a) != 1;
  }
  CountFans(mesh.vertex_count(), mesh.faces, report);
  const double diagonal = BoundingDiagonal(mesh.points);
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    report.zero_area_faces +=
        FaceCross(mesh.points, mesh.faces, f).norm() <= 1e-14 * diagonal * diagonal;
  report.components = CountComponents(mesh.vertex_count(), mesh.faces);
  report.euler =
      mesh.vertex_count() - report.unused_vertices - mesh.face_count() * 3 / 2 + mesh.face_count();
  report.volume = SignedVolume(mesh.points, mesh.faces);
  return report;
}

SurfaceSamples SampleSurface(const PointsX3& points, const FacesX3& faces, int count,
                             std::uint64_t seed) {
  SurfaceSamples samples;
  if (faces.rows() == 0) return samples;
  const Eigen::VectorXd areas = FaceAreas(points, faces);
  std::vector<double> cumulative(static_cast<std::size_t>(areas.size()));
  std::partial_sum(areas.data(), areas.data() + areas.size(), cumulative.begin());
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
  samples.points.resize(count, 3);
  samples.faces.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const auto it =
        std::upper_bound(cumulative.begin(), cumulative.end(), uniform() * cumulative.back());
    const auto f = std::min<Eigen::Index>(it - cumulative.begin(), faces.rows() - 1);
    const double r = std::sqrt(uniform()), s = uniform();
    samples.points.row(i) = (1 - r) * points.row(faces(f, 0)) +
                            r * (1 - s) * points.row(faces(f, 1)) + r * s * points.row(faces(f, 2));
    samples.faces[i] = static_cast<int>(f);
  }
  return samples;
}

}  // namespace keypose
