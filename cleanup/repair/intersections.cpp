#include "cleanup/repair/intersections.h"

#include <utility>

#include "cleanup/editing/adapt.h"
#include "cleanup/repair/components.h"
#include "cleanup/repair/holes.h"
#include "cleanup/repair/soup.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/self_intersections.h"

namespace keypose::cleanup {

Mesh Without(const Mesh& mesh, const std::vector<int>& faces, int rings) {
  std::vector<char> gone(mesh.face_count(), 0), near(mesh.vertex_count(), 0);
  for (const int f : faces) gone[f] = 1;
  for (int ring = 0; ring < rings; ++ring) {
    for (int f = 0; f < mesh.face_count(); ++f)
      for (int k = 0; k < 3; ++k)
        if (gone[f]) near[mesh.faces(f, k)] = 1;
    for (int f = 0; f < mesh.face_count(); ++f)
      gone[f] |= near[mesh.faces(f, 0)] || near[mesh.faces(f, 1)] || near[mesh.faces(f, 2)];
  }
  Mesh open;
  open.points = mesh.points;
  open.faces.resize(mesh.face_count(), 3);
  int count = 0;
  for (int f = 0; f < mesh.face_count(); ++f)
    if (!gone[f]) open.faces.row(count++) = mesh.faces.row(f);
  open.faces.conservativeResize(count, 3);
  return open;
}

bool SelfIntersects(const Mesh& mesh) {
  return HasSelfIntersections(mesh.points, mesh.faces, TouchingFaces::kCounted);
}

std::vector<int> IntersectingFaces(const Mesh& mesh, int* pair_count) {
  SelfIntersections found = FindSelfIntersections(mesh.points, mesh.faces, TouchingFaces::kCounted);
  if (pair_count) *pair_count = static_cast<int>(found.pairs);
  return std::move(found.faces);
}

// CGAL's own remove_self_intersections (5.5) has hung and crashed on damaged meshes.
Mesh WithoutIntersections(const Mesh& closed, int rounds) {
  Mesh mesh = closed;
  for (int round = 0; round < rounds; ++round) {
    const std::vector<int> bad = IntersectingFaces(mesh);
    if (bad.empty()) break;
    // First with curved patches. If these intersect something again, with membranes, which stay
    // within their rims.
    const double large_hole = round < 2 || round % 2 == 1 ? 0.1 : 0;
    const Mesh open = Without(mesh, bad, (round + 1) / 2);
    if (open.face_count() == 0) return {};
    int dropped = 0;
    mesh =
        FillHoles(WithoutBits(OrientedManifold(open, 0).mesh, 0.01, &dropped), nullptr, large_hole)
            .mesh;
    if (CheckClosed(mesh).zero_area_faces > 0) mesh = WithoutThinAngles(mesh, 1);
  }
  return mesh;
}

}  // namespace keypose::cleanup
