#include "synth/outer_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "core/geometry.h"
#include "core/kd_tree.h"
#include "core/parallel.h"
#include "core/ray_scene.h"
#include "synth/polygonize.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

// Directions that no lattice plane and no upright wall is parallel to.
const std::array<Vector3d, 3> kDirections = {Vector3d(0.36, 0.48, 0.80).normalized(), Vector3d(-0.71, 0.23, 0.66).normalized(),
                                             Vector3d(0.19, -0.87, 0.45).normalized()};

/// How often the surface wraps a point, by the walls that a ray crosses on its way out.
int Winding(const RayScene& scene, const PointsX3& normals, const Vector3d& x, const Vector3d& direction) {
  constexpr double kStep = 2e-7;  // [m] beyond a wall: more than single precision's rounding at this size, less than any gap
  int winding = 0;
  double from = 0;
  for (int walls = 0; walls < 1000; ++walls) {
    const RayScene::Hit hit = scene.Cast(x, direction, from);
    if (hit.face < 0) break;
    winding += normals.row(hit.face).dot(direction) > 0 ? 1 : -1;
    from = hit.distance + kStep;
  }
  return winding;
}

bool Inside(const RayScene& scene, const PointsX3& normals, const Vector3d& x) {
  // A ray that grazes an edge may count it twice or not at all: two that agree are right.
  const bool first = Winding(scene, normals, x, kDirections[0]) > 0, second = Winding(scene, normals, x, kDirections[1]) > 0;
  return first == second ? first : Winding(scene, normals, x, kDirections[2]) > 0;
}

using Field = std::function<double(const Vector3d&)>;

/// Vertices that lie within the solid, away from what one sees of it.
PointsX3 Buried(const RayScene& scene, const Mesh& posed, const PointsX3& face_normals) {
  constexpr double kOff = 1e-5;  // [m]
  const PointsX3 normals = VertexNormals(posed.points, posed.faces);
  std::vector<char> is_buried(posed.points.rows());
  const auto look = [&](std::int64_t v) {
    is_buried[v] = Inside(scene, face_normals, Vector3d(posed.points.row(v) + kOff * normals.row(v)));
  };
  ParallelFor(posed.points.rows(), look, 256);
  std::vector<int> found;
  for (std::size_t v = 0; v < is_buried.size(); ++v)
    if (is_buried[v]) found.push_back(static_cast<int>(v));
  return posed.points(found, Eigen::all);
}

struct Box {
  Vector3d low, high;
  Box(const PointsX3& points, double margin)
      : low(points.colwise().minCoeff().transpose() - Vector3d::Constant(margin)),
        high(points.colwise().maxCoeff().transpose() + Vector3d::Constant(margin)) {}
  /// Negative inside; never more than the distance to the box's sides.
  double Distance(const Vector3d& x) const { return (low - x).cwiseMax(x - high).maxCoeff(); }
};

/// The field near `points` less crevices narrower than 2 * radius: the solid grown and shrunk again (a morphological closing).
Field Closed(const Field& solid, const PointsX3& points, double reach, double radius, double spacing) {
  const Box part(points, reach + 4 * spacing), around(points, reach + 6 * spacing);
  const auto grown_part = [&](const Vector3d& x) { return std::max(solid(x) - radius, part.Distance(x)); };
  const Mesh grown = Polygonize(grown_part, around.low, around.high, spacing, 1.0);
  const auto scene = std::make_shared<RayScene>(grown.points, grown.faces);
  return [solid, scene, radius](const Vector3d& x) {
    const double open = solid(x);
    return open >= radius ? open : radius - std::sqrt(scene->ClosestPoint(x).squared_distance);
  };
}

}  // namespace

Mesh OuterSurface(const Mesh& posed, double spacing) {
  const RayScene scene(posed.points, posed.faces);
  const PointsX3 normals = FaceNormals(posed.points, posed.faces);
  const Field solid = [&](const Vector3d& x) {
    const double distance = std::sqrt(scene.ClosestPoint(x).squared_distance);
    return Inside(scene, normals, x) ? -distance : distance;
  };
  const Box whole(posed.points, 2 * spacing);
  const PointsX3 buried = Buried(scene, posed, normals);
  if (buried.rows() == 0) return Polygonize(solid, whole.low, whole.high, spacing, 1.0);
  // Where two walls meet at a flat angle, the lattice would leave pinholes between them.
  const double crevice = spacing / 2, reach = 3 * spacing;
  const Field closed = Closed(solid, buried, reach, crevice, spacing);
  const KdTree seam(buried);
  const Field field = [&](const Vector3d& x) { return std::sqrt(seam.Nearest(x).squared_distance) < reach ? closed(x) : solid(x); };
  return Polygonize(field, whole.low, whole.high, spacing, 1.0);
}

int Genus(const Mesh& closed) {
  const ClosedReport report = CheckClosed(closed);
  return report.components - report.euler / 2;
}

}  // namespace keypose::synth
