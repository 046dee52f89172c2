#include <Eigen/Geometry>
#include <cmath>

#include "cleanup/repair/intersections.h"
#include "cleanup/repair/wrap.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"

namespace keypose::cleanup {
namespace {

// Moves by nine tenths of the distance: else both walls around a thin sheet would meet in it.
constexpr double kShare = 0.9;
constexpr int kProjectionRounds = 8;

PointsX3 Targets(const Mesh& wrap, const Mesh& soup, double reach) {
  const RayScene scene(soup.points, soup.faces);
  const PointsX3 normals = VertexNormals(wrap.points, wrap.faces);
  PointsX3 targets = wrap.points;
  ParallelFor(
      wrap.vertex_count(),
      [&](std::int64_t v) {
        const Eigen::Vector3d x = wrap.points.row(v).transpose();
        const RayScene::Foot foot = scene.ClosestPoint(x, reach);
        if (foot.face < 0) return;
        const Eigen::Vector3d move = foot.point - x;
        if (-move.dot(normals.row(v).transpose()) >= std::cos(EIGEN_PI / 4) * move.norm())
          targets.row(v) += kShare * move.transpose();
      },
      256);
  return targets;
}

// Faces that turned by more than a right angle or lost nearly all of their area.
std::vector<int> FlippedFaces(const Mesh& before, const PointsX3& after) {
  std::vector<int> flipped;
  for (int f = 0; f < before.face_count(); ++f) {
    const auto cross = [&](const PointsX3& p) -> Eigen::Vector3d {
      const Eigen::Vector3d a = p.row(before.faces(f, 0)), b = p.row(before.faces(f, 1)),
                            c = p.row(before.faces(f, 2));
      return (b - a).cross(c - a);
    };
    const Eigen::Vector3d n0 = cross(before.points), n1 = cross(after);
    if (n1.dot(n0) <= 0 || n1.norm() < 1e-3 * n0.norm()) flipped.push_back(f);
  }
  return flipped;
}

// Moves the corners of the faces, and in later rounds their neighbours, back to their positions in
// the wrap.
void Revert(const Mesh& wrap, const std::vector<int>& faces, int rings, PointsX3& points) {
  std::vector<char> chosen(wrap.vertex_count(), 0);
  for (const int f : faces)
    for (int k = 0; k < 3; ++k) chosen[wrap.faces(f, k)] = 1;
  for (int ring = 0; ring < rings; ++ring) {
    std::vector<char> grown = chosen;
    for (int f = 0; f < wrap.face_count(); ++f) {
      if (!chosen[wrap.faces(f, 0)] && !chosen[wrap.faces(f, 1)] && !chosen[wrap.faces(f, 2)])
        continue;
      for (int k = 0; k < 3; ++k) grown[wrap.faces(f, k)] = 1;
    }
    chosen = grown;
  }
  for (int v = 0; v < wrap.vertex_count(); ++v)
    if (chosen[v]) points.row(v) = wrap.points.row(v);
}

}  // namespace

Mesh ProjectedBack(const Mesh& wrap, const Mesh& soup, double reach) {
  Mesh moved = wrap;
  moved.points = Targets(wrap, soup, reach);
  for (int round = 0; round < kProjectionRounds; ++round) {
    std::vector<int> bad = FlippedFaces(wrap, moved.points);
    if (bad.empty()) bad = IntersectingFaces(moved);
    if (bad.empty()) return moved;
    Revert(wrap, bad, round / 2, moved.points);
  }
  return wrap;
}

}  // namespace keypose::cleanup
