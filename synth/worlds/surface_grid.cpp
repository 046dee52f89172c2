#include "synth/worlds/surface_grid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "synth/worlds/noise.h"
#include "synth/worlds/polygonize.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

Mesh PolygonizeClay(const Clay& clay, double spacing) {
  Vector3d low, high;
  clay.Bounds(&low, &high);
  return Polygonize([&](const Vector3d& x) { return clay.Distance(x); },
                    low - Vector3d::Constant(2 * spacing), high + Vector3d::Constant(2 * spacing),
                    spacing);
}

// An edge with its two faces and the corners opposite to it.
struct Edge {
  int a, b, face[2], opposite[2];
};

std::uint64_t EdgeKey(int a, int b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 |
         static_cast<std::uint32_t>(std::max(a, b));
}

std::vector<Edge> EdgesOf(const FacesX3& faces, std::unordered_map<std::uint64_t, int>* index) {
  std::vector<Edge> edges;
  index->clear();
  for (int f = 0; f < static_cast<int>(faces.rows()); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3), c = faces(f, (k + 2) % 3);
      const auto [it, is_new] = index->try_emplace(EdgeKey(a, b), SizeOf(edges));
      if (is_new) {
        edges.push_back({a, b, {f, -1}, {c, -1}});
      } else {
        edges[it->second].face[1] = f;
        edges[it->second].opposite[1] = c;
      }
    }
  return edges;
}

double AngleAt(const PointsX3& p, int corner, int a, int b) {
  const Vector3d u = p.row(a) - p.row(corner), v = p.row(b) - p.row(corner);
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

Vector3d Normal(const PointsX3& p, int a, int b, int c) {
  const Vector3d u = p.row(b) - p.row(a), v = p.row(c) - p.row(a);
  return u.cross(v).normalized();
}

// Whether the quad's other diagonal gives better-shaped triangles and no crease. In the face of a,
// the edge runs a -> b.
bool ShouldFlip(const PointsX3& p, const Edge& e) {
  constexpr double kFlat = 0.8;
  const int c = e.opposite[0], d = e.opposite[1];
  if (AngleAt(p, c, e.a, e.b) + AngleAt(p, d, e.a, e.b) < kPi + 1e-6) return false;
  const Vector3d before = Normal(p, e.a, e.b, c) + Normal(p, e.b, e.a, d);
  const Vector3d first = Normal(p, c, d, e.b), second = Normal(p, d, c, e.a);
  return first.dot(before.normalized()) > kFlat && second.dot(before.normalized()) > kFlat;
}

// One round of flips of edges that share no face with another flip of the round. @return number of
// flips
int FlipRound(Mesh* mesh) {
  std::unordered_map<std::uint64_t, int> index;
  const std::vector<Edge> edges = EdgesOf(mesh->faces, &index);
  std::vector<int> valence(mesh->points.rows(), 0);
  for (const Edge& e : edges) {
    ++valence[e.a];
    ++valence[e.b];
  }
  std::vector<char> touched(mesh->faces.rows(), 0);
  int flips = 0;
  for (const Edge& e : edges) {
    if (e.face[1] < 0 || touched[e.face[0]] || touched[e.face[1]] || valence[e.a] < 5 ||
        valence[e.b] < 5)
      continue;
    const int c = e.opposite[0], d = e.opposite[1];
    if (!ShouldFlip(mesh->points, e) || !index.try_emplace(EdgeKey(c, d), -1).second) continue;
    mesh->faces.row(e.face[0]) << c, d, e.b;
    mesh->faces.row(e.face[1]) << d, c, e.a;
    touched[e.face[0]] = touched[e.face[1]] = 1;
    --valence[e.a];
    --valence[e.b];
    ++valence[c];
    ++valence[d];
    ++flips;
  }
  return flips;
}

// Moves each vertex to the area-weighted mean of its faces' centroids, and back onto the surface.
void RelaxRound(Mesh* mesh, const PosedSurface& surface) {
  PointsX3 sum = PointsX3::Zero(mesh->points.rows(), 3);
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(mesh->points.rows());
  const Eigen::VectorXd areas = FaceAreas(mesh->points, mesh->faces);
  for (Eigen::Index f = 0; f < mesh->faces.rows(); ++f) {
    const auto corners = mesh->faces.row(f);
    const Eigen::RowVector3d center = (mesh->points.row(corners[0]) + mesh->points.row(corners[1]) +
                                       mesh->points.row(corners[2])) /
                                      3;
    for (int k = 0; k < 3; ++k) {
      sum.row(corners[k]) += areas[f] * center;
      weight[corners[k]] += areas[f];
    }
  }
  const auto move = [&](std::int64_t i) {
    if (weight[i] > 0)
      mesh->points.row(i) = surface.Closest(sum.row(i).transpose() / weight[i]).transpose();
  };
  ParallelFor(mesh->points.rows(), move, 64);
}

/// Each vertex moved onto its target, without the faces that vanish.
Mesh Joined(const Mesh& mesh, const std::vector<int>& target) {
  std::vector<int> place(target.size(), -1);
  std::vector<int> kept;
  for (std::size_t i = 0; i < target.size(); ++i)
    if (target[i] == static_cast<int>(i)) {
      place[i] = SizeOf(kept);
      kept.push_back(static_cast<int>(i));
    }
  Mesh joined;
  joined.points = mesh.points(kept, Eigen::all);
  std::vector<int> corners;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    const int a = place[target[mesh.faces(f, 0)]], b = place[target[mesh.faces(f, 1)]],
              c = place[target[mesh.faces(f, 2)]];
    if (a != b && b != c && c != a) corners.insert(corners.end(), {a, b, c});
  }
  joined.faces =
      Eigen::Map<const FacesX3>(corners.data(), static_cast<Eigen::Index>(corners.size() / 3), 3);
  return joined;
}

// Collapses very short edges if the result stays a manifold.
void CollapseRound(Mesh* mesh, double shorter_than) {
  std::unordered_map<std::uint64_t, int> index;
  const std::vector<Edge> edges = EdgesOf(mesh->faces, &index);
  std::vector<std::vector<int>> neighbours(mesh->points.rows());
  for (const Edge& e : edges) {
    neighbours[e.a].push_back(e.b);
    neighbours[e.b].push_back(e.a);
  }
  std::vector<char> touched(mesh->points.rows(), 0);
  std::vector<int> target(mesh->points.rows());
  for (std::size_t i = 0; i < target.size(); ++i) target[i] = static_cast<int>(i);
  for (const Edge& e : edges) {
    if ((mesh->points.row(e.a) - mesh->points.row(e.b)).norm() >= shorter_than) continue;
    std::vector<int> ring = neighbours[e.a];
    ring.insert(ring.end(), neighbours[e.b].begin(), neighbours[e.b].end());
    if (std::any_of(ring.begin(), ring.end(), [&](int v) { return touched[v]; })) continue;
    std::sort(ring.begin(), ring.end());
    int shared = 0;  // link condition: exactly the two opposite corners
    for (std::size_t i = 1; i < ring.size(); ++i) shared += ring[i] == ring[i - 1];
    const auto valence = [&](int v) { return neighbours[v].size(); };
    if (shared != 2 || valence(e.opposite[0]) < 5 || valence(e.opposite[1]) < 5) continue;
    mesh->points.row(e.a) = (mesh->points.row(e.a) + mesh->points.row(e.b)) / 2;
    target[e.b] = e.a;
    for (const int v : ring) touched[v] = 1;
  }
  *mesh = Joined(*mesh, target);
}

double MeanEdge(const Mesh& mesh) {
  double sum = 0;
  const auto edges = UndirectedEdges(mesh.faces);
  for (const auto& [a, b] : edges) sum += (mesh.points.row(a) - mesh.points.row(b)).norm();
  return sum / static_cast<double>(edges.size());
}

// Marching leaves slivers where lattice points are close to the surface.
void Even(Mesh* mesh, const PosedSurface& surface) {
  for (int round = 0; round < 3; ++round) CollapseRound(mesh, 0.5 * MeanEdge(*mesh));
  for (int round = 0; round < 12; ++round) {
    for (int flip = 0; flip < 8 && FlipRound(mesh) > 0; ++flip) {
    }
    RelaxRound(mesh, surface);
    if (round < 4) CollapseRound(mesh, 0.5 * MeanEdge(*mesh));
  }
}

// Each seed gives a lattice with a random rotation and shift.
Mesh EvenMesh(const PosedSurface& surface, double spacing, std::uint64_t seed) {
  Random random(Hash(seed) + 77);
  Eigen::Quaterniond draw;  // one number a line: compilers differ in the order of arguments
  draw.z() = random.Normal();
  draw.y() = random.Normal();
  draw.x() = random.Normal();
  draw.w() = random.Normal();
  const Eigen::Matrix3d turn = draw.normalized().matrix();
  const PointsX3 turned = surface.points() * turn;  // rows: turn^T x
  Vector3d low = turned.colwise().minCoeff(), high = turned.colwise().maxCoeff();
  for (int k = 0; k < 3; ++k) low[k] -= spacing * (2 + random.Uniform());
  high.array() += 3 * spacing;
  Mesh mesh =
      Polygonize([&](const Vector3d& x) { return surface.Distance(turn * x); }, low, high, spacing);
  mesh.points = PointsX3(mesh.points * turn.transpose());
  Even(&mesh, surface);
  return mesh;
}

}  // namespace

PosedSurface::PosedSurface(const Clay& clay, const Pose& pose, double spacing)
    : clay_(clay),
      pose_(pose),
      rest_(PolygonizeClay(clay, spacing)),
      points_(pose(rest_.points)),
      normals_(FaceNormals(points_, rest_.faces)),
      scene_(points_, rest_.faces),
      area_(SurfaceArea(points_, rest_.faces)) {}

double PosedSurface::Distance(const Vector3d& posed) const {
  const RayScene::Foot foot = scene_.ClosestPoint(posed);
  const double distance = std::sqrt(foot.squared_distance);
  return normals_.row(foot.face).dot((posed - foot.point).transpose()) < 0 ? -distance : distance;
}

Vector3d PosedSurface::MaterialAt(const Vector3d& posed) const {
  const RayScene::Foot foot = scene_.ClosestPoint(posed);
  Vector3d x = Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    x += foot.barycentric[k] * rest_.points.row(rest_.faces(foot.face, k)).transpose();
  for (int round = 0; round < 6; ++round) {  // the chords of the dense mesh lie slightly inside
    const double value = clay_.Distance(x);
    if (std::abs(value) < 1e-12) break;
    const Vector3d gradient = clay_.Gradient(x);
    x -= value / std::max(gradient.squaredNorm(), 0.01) * gradient;
  }
  return x;
}

Tessellation Tessellate(const PosedSurface& surface, int vertices, std::uint64_t seed) {
  if (vertices < 50)
    throw InputError("synth: a mesh of a clay solid needs at least 50 vertices; use more");
  double spacing = std::sqrt(5 * surface.area() / vertices);
  Mesh mesh = EvenMesh(surface, spacing, seed);
  // The vertex count for a spacing depends on the shape: measure it and correct the spacing.
  for (int round = 0;
       round < 2 && std::abs(mesh.points.rows() / static_cast<double>(vertices) - 1) > 0.02;
       ++round) {
    spacing *= std::sqrt(static_cast<double>(mesh.points.rows()) / vertices);
    mesh = EvenMesh(surface, spacing, seed);
  }
  Tessellation result;
  result.material.resize(mesh.points.rows(), 3);
  const auto place = [&](std::int64_t i) {
    result.material.row(i) = surface.MaterialAt(mesh.points.row(i)).transpose();
    mesh.points.row(i) = surface.pose()(Vector3d(result.material.row(i))).transpose();
  };
  ParallelFor(mesh.points.rows(), place, 64);
  result.mesh = std::move(mesh);
  return result;
}

}  // namespace keypose::synth
