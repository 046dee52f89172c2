#include "deform/mending/brushed.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/values/errors.h"

namespace keypose {
namespace {

using Eigen::Vector3d;

/// The nearest point of a path: between place `from` and the next one.
struct OnPath {
  double distance = std::numeric_limits<double>::infinity();
  int from = 0;
  double along = 0;  ///< 0 to 1
};

OnPath NearestOnPath(const std::vector<Vector3d>& path, const Vector3d& point) {
  OnPath nearest;
  nearest.distance = (path[0] - point).norm();
  for (int i = 0; i + 1 < std::ssize(path); ++i) {
    const Vector3d step = path[i + 1] - path[i];
    const double length = step.squaredNorm();
    const double along = length > 0 ? std::clamp((point - path[i]).dot(step) / length, 0., 1.) : 0;
    const double distance = (path[i] + along * step - point).norm();
    if (distance < nearest.distance) nearest = {distance, i, along};
  }
  return nearest;
}

/// A bell of width 1 that ends with a slope of 0.
double Bell(double distance) {
  const double left = 1 - distance * distance;
  return left > 0 ? left * left : 0;
}

std::vector<Vector3d> PathOf(const Mesh& mesh, const PointsX3& points, const MendStroke& stroke) {
  std::vector<Vector3d> path;
  for (const MendStroke::Place& place : stroke.places) {
    if (place.face < 0 || place.face >= mesh.face_count())
      throw InputError("a place of the brush is on face " + std::to_string(place.face) +
                       ", but the mesh has " + std::to_string(mesh.face_count()) + " faces");
    Vector3d at = Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      at += place.barycentric[k] * points.row(mesh.faces(place.face, k)).transpose();
    path.push_back(at);
  }
  return path;
}

/// The area of a face times its normal, doubled.
Vector3d AreaVector(const Mesh& mesh, const PointsX3& points, int face) {
  const auto corner = [&](int k) -> Vector3d { return points.row(mesh.faces(face, k)); };
  return (corner(1) - corner(0)).cross(corner(2) - corner(0));
}

/// Grows from the faces of the places over vertices that lie near enough to the path.
std::vector<int> Grown(const Mesh& mesh, const MeshRings& rings, const PointsX3& points,
                       const MendStroke& stroke, const std::vector<Vector3d>& path) {
  std::vector<char> seen(static_cast<std::size_t>(mesh.vertex_count()), 0);
  std::vector<int> found, open;
  const auto meet = [&](int vertex) {
    if (seen[vertex]) return;
    seen[vertex] = 1;
    if (NearestOnPath(path, points.row(vertex)).distance < stroke.radius) open.push_back(vertex);
  };
  for (const MendStroke::Place& place : stroke.places)
    for (int k = 0; k < 3; ++k) meet(mesh.faces(place.face, k));
  while (!open.empty()) {
    const int vertex = open.back();
    open.pop_back();
    found.push_back(vertex);
    for (const int next : rings.neighbours[vertex]) meet(next);
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// The mean direction of the brushed surface round each place.
std::vector<Vector3d> DirectionsOf(const Mesh& mesh, const MeshRings& rings, const PointsX3& points,
                                   const MendStroke& stroke, const std::vector<Vector3d>& path,
                                   const std::vector<int>& vertices) {
  std::vector<Vector3d> directions(path.size(), Vector3d::Zero());
  for (std::size_t i = 0; i < path.size(); ++i) {
    for (const int v : vertices) {
      const double weight = Bell((points.row(v).transpose() - path[i]).norm() / stroke.radius);
      if (weight <= 0) continue;
      for (const int face : rings.faces[v])
        directions[i] += weight * AreaVector(mesh, points, face);
    }
    if (directions[i].norm() <= 0) directions[i] = AreaVector(mesh, points, stroke.places[i].face);
    directions[i].normalize();
  }
  return directions;
}

}  // namespace

MeshRings::MeshRings(const Mesh& mesh)
    : neighbours(static_cast<std::size_t>(mesh.vertex_count())), faces(neighbours.size()) {
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int vertex = mesh.faces(f, k);
      faces[vertex].push_back(f);
      neighbours[vertex].push_back(mesh.faces(f, (k + 1) % 3));
      neighbours[vertex].push_back(mesh.faces(f, (k + 2) % 3));
    }
  for (std::vector<int>& ring : neighbours) {
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
  }
}

Brushed UnderBrush(const Mesh& mesh, const MeshRings& rings, const PointsX3& points,
                   const MendStroke& stroke) {
  Brushed brushed;
  const std::vector<Vector3d> path = PathOf(mesh, points, stroke);
  if (path.empty()) return brushed;
  brushed.vertices = Grown(mesh, rings, points, stroke, path);
  const std::vector<Vector3d> directions =
      DirectionsOf(mesh, rings, points, stroke, path, brushed.vertices);
  brushed.directions.resize(std::ssize(brushed.vertices), 3);
  for (std::size_t i = 0; i < brushed.vertices.size(); ++i) {
    const OnPath on = NearestOnPath(path, points.row(brushed.vertices[i]));
    brushed.weights.push_back(Bell(on.distance / stroke.radius));
    const std::size_t from = static_cast<std::size_t>(on.from);
    const std::size_t to = std::min(from + 1, path.size() - 1);
    brushed.directions.row(static_cast<Eigen::Index>(i)) =
        ((1 - on.along) * directions[from] + on.along * directions[to]).normalized();
  }
  return brushed;
}

}  // namespace keypose
