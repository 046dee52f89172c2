#include "synth/worlds/outer_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "synth/worlds/polygonize.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

// Directions that are parallel to no lattice plane and no vertical wall.
const std::array<Vector3d, 3> kDirections = {Vector3d(0.36, 0.48, 0.80).normalized(),
                                             Vector3d(-0.71, 0.23, 0.66).normalized(),
                                             Vector3d(0.19, -0.87, 0.45).normalized()};

/// Winding number of the surface around a point, from the walls that a ray crosses.
int Winding(const RayScene& scene, const PointsX3& normals, const Vector3d& x,
            const Vector3d& direction) {
  constexpr double kStep = 2e-7;  // [m] beyond a wall: more than the rounding of single precision
                                  // at this size, less than any gap
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
  // A ray that grazes an edge may count it twice or not at all; if two rays agree, they are right.
  const bool first = Winding(scene, normals, x, kDirections[0]) > 0,
             second = Winding(scene, normals, x, kDirections[1]) > 0;
  return first == second ? first : Winding(scene, normals, x, kDirections[2]) > 0;
}

/// Negative inside. The sign comes from rays, since the surface may intersect itself.
class SignedDistance {
 public:
  explicit SignedDistance(const Mesh& mesh)
      : scene_(mesh.points, mesh.faces), normals_(FaceNormals(mesh.points, mesh.faces)) {}
  double operator()(const Vector3d& x) const {
    const double distance = std::sqrt(scene_.ClosestPoint(x).squared_distance);
    return Inside(scene_, normals_, x) ? -distance : distance;
  }

 private:
  RayScene scene_;
  PointsX3 normals_;
};

Mesh Offset(const Mesh& mesh, double by, double spacing) {
  const SignedDistance distance(mesh);
  const Vector3d margin = Vector3d::Constant(std::max(by, 0.0) + 2 * spacing);
  const Vector3d low = mesh.points.colwise().minCoeff().transpose(),
                 high = mesh.points.colwise().maxCoeff().transpose();
  return Polygonize([&](const Vector3d& x) { return distance(x) - by; }, low - margin,
                    high + margin, spacing, 1.0);
}

}  // namespace

Mesh OuterSurface(const Mesh& posed, double spacing) {
  // Where two walls meet at a small angle, the lattice would leave pinholes, which pressed clay
  // does not have. Growing and shrinking the solid (morphological closing) closes them.
  constexpr double kCrevice = 0.001;  // [m] radius of the ball that cannot enter
  const double crevice = std::max(spacing / 2, kCrevice);
  return Offset(Offset(posed, crevice, spacing), -crevice, spacing);
}

int Genus(const Mesh& closed) {
  const ClosedReport report = CheckClosed(closed);
  return report.components - report.euler / 2;
}

}  // namespace keypose::synth
