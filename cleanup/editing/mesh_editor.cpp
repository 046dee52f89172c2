#include "cleanup/editing/mesh_editor.h"

#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/Euler_operations.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "cleanup/editing/cgal_convert.h"

namespace keypose::cleanup {

using Eigen::Vector3d;

namespace {

constexpr double kMostTurn =
    0.3;  // smallest cosine of the angle by which a face may turn in one step

}  // namespace

double MinAngle(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const auto angle = [](const Vector3d& u, const Vector3d& v) {
    return std::atan2(u.cross(v).norm(), u.dot(v));
  };
  return std::min({angle(b - a, c - a), angle(a - b, c - b), angle(a - c, b - c)});
}

Editor::Editor(const Mesh& closed)
    : owned_(std::make_unique<SurfaceMesh>(ToSurfaceMesh<SurfaceMesh>(closed))),
      mesh(*owned_),
      sizes(mesh.number_of_vertices(), 1.0) {}

Editor::~Editor() = default;

double Editor::Length(Edge e) const {
  return (mesh.point(mesh.vertex(e, 0)) - mesh.point(mesh.vertex(e, 1))).norm();
}

double Editor::Relative(Edge e) const {
  return Length(e) / (0.5 * (sizes[mesh.vertex(e, 0)] + sizes[mesh.vertex(e, 1)]));
}

Vector3d Editor::Cross(Face f) const {
  const Halfedge h = mesh.halfedge(f);
  const Vector3d &a = mesh.point(mesh.source(h)), &b = mesh.point(mesh.target(h)),
                 &c = mesh.point(mesh.target(mesh.next(h)));
  return (b - a).cross(c - a);
}

double Editor::Angle(Face f) const {
  const Halfedge h = mesh.halfedge(f);
  return MinAngle(mesh.point(mesh.source(h)), mesh.point(mesh.target(h)),
                  mesh.point(mesh.target(mesh.next(h))));
}

double Editor::Angle(Vertex v) const {
  double least = EIGEN_PI;
  for (const Halfedge h : CGAL::halfedges_around_target(mesh.halfedge(v), mesh))
    least = std::min(least, Angle(mesh.face(h)));
  return least;
}

Vector3d Editor::Normal(Vertex v) const {
  Vector3d sum = Vector3d::Zero();
  for (const Halfedge h : CGAL::halfedges_around_target(mesh.halfedge(v), mesh))
    sum += Cross(mesh.face(h));
  return sum.normalized();
}

// Whether the faces around v, except those that also touch `ignored`, keep their orientation and an
// area when v moves.
bool Editor::StarHolds(Vertex v, const Vector3d& to, Vertex ignored) const {
  for (const Halfedge h : CGAL::halfedges_around_target(mesh.halfedge(v), mesh)) {
    const Vertex p = mesh.source(h), q = mesh.target(mesh.next(h));
    if (p == ignored || q == ignored) continue;
    const Vector3d &a = mesh.point(p), &b = mesh.point(q), &old = mesh.point(v);
    const Vector3d before = (old - a).cross(b - a), after = (to - a).cross(b - a);
    const double scale = (b - a).squaredNorm() + (to - a).squaredNorm();
    if (!(after.norm() > 1e-3 * scale)) {
      if (!(after.norm() > before.norm())) return false;  // thin faces may only improve
    }
    if (before.norm() > 1e-9 * scale &&
        !(after.dot(before) > kMostTurn * after.norm() * before.norm()))
      return false;
  }
  return true;
}

double Editor::PlaneError(Vertex v, const Vector3d& x) const {
  double error = 0;
  for (const Halfedge h : CGAL::halfedges_around_target(mesh.halfedge(v), mesh)) {
    const Vector3d cross = Cross(mesh.face(h));
    const double area = cross.norm();
    if (area > 0) error += std::pow(cross.dot(x - mesh.point(v)), 2) / area;
  }
  return error;
}

Vertex Editor::Split(Edge e) {
  const Halfedge h = mesh.halfedge(e);
  const Vertex a = mesh.source(h), b = mesh.target(h);
  const Halfedge first = CGAL::Euler::split_edge(h, mesh);
  const Vertex middle = mesh.target(first);
  mesh.point(middle) = 0.5 * (mesh.point(a) + mesh.point(b));
  sizes.resize(std::max<std::size_t>(sizes.size(), middle.idx() + 1));
  sizes[middle] = 0.5 * (sizes[a] + sizes[b]);
  CGAL::Euler::split_face(first, mesh.next(h), mesh);
  const Halfedge back = mesh.opposite(h);  // from b to the middle, in the other face
  CGAL::Euler::split_face(back, mesh.next(mesh.next(back)), mesh);
  return middle;
}

bool Editor::Collapse(Edge e, double longest) {
  const Halfedge h = mesh.halfedge(e);
  const Vertex a = mesh.source(h), b = mesh.target(h);
  if (!CGAL::Euler::does_satisfy_link_condition(e, mesh) || mesh.number_of_faces() <= 4)
    return false;
  // A tube of three edges must not be closed, and no vertex may be left with two faces.
  if (mesh.degree(mesh.target(mesh.next(h))) <= 3 ||
      mesh.degree(mesh.target(mesh.next(mesh.opposite(h)))) <= 3)
    return false;
  const Vector3d pa = mesh.point(a), pb = mesh.point(b);
  std::array<Vector3d, 3> places = {0.5 * (pa + pb), pa, pb};
  std::array<double, 3> errors;
  for (int i = 0; i < 3; ++i) errors[i] = PlaneError(a, places[i]) + PlaneError(b, places[i]);
  std::array<int, 3> order = {0, 1, 2};
  // The midpoint gives the best triangles, so an end is only chosen when it is clearly better for
  // the shape.
  errors[0] *= 0.5;
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return errors[i] < errors[j]; });
  const double size = 0.5 * (sizes[a] + sizes[b]);
  for (const int i : order) {
    if (!StarHolds(a, places[i], b) || !StarHolds(b, places[i], a)) continue;
    bool fits = true;
    for (const Vertex v : {a, b})
      for (const Halfedge g : CGAL::halfedges_around_target(mesh.halfedge(v), mesh)) {
        const Vertex w = mesh.source(g);
        if (w != a && w != b &&
            (mesh.point(w) - places[i]).norm() > longest * 0.5 * (size + sizes[w]))
          fits = false;
      }
    if (!fits) continue;
    const Vertex kept = CGAL::Euler::collapse_edge(e, mesh);
    mesh.point(kept) = places[i];
    sizes[kept] = size;
    return true;
  }
  return false;
}

bool Editor::Flip(Edge e) {
  const Halfedge h = mesh.halfedge(e), o = mesh.opposite(h);
  const Vertex a = mesh.source(h), b = mesh.target(h), c = mesh.target(mesh.next(h)),
               d = mesh.target(mesh.next(o));
  if (c == d || mesh.degree(a) <= 3 || mesh.degree(b) <= 3 ||
      mesh.halfedge(c, d) != SurfaceMesh::null_halfedge())
    return false;
  const Vector3d &pa = mesh.point(a), &pb = mesh.point(b), &pc = mesh.point(c), &pd = mesh.point(d);
  const double before = std::min(MinAngle(pa, pb, pc), MinAngle(pb, pa, pd));
  const double after = std::min(MinAngle(pc, pd, pb), MinAngle(pd, pc, pa));
  if (after <= before * 1.0001 + 1e-9) return false;
  const Vector3d n0 = (pb - pa).cross(pc - pa), n1 = (pa - pb).cross(pd - pb);
  const Vector3d m0 = (pd - pc).cross(pb - pc), m1 = (pc - pd).cross(pa - pd);
  const Vector3d mean = n0 + n1;
  const auto cosine = [](const Vector3d& u, const Vector3d& v) {
    const double norm = u.norm() * v.norm();
    return norm > 0 ? u.dot(v) / norm : -1;
  };
  if (cosine(m0, mean) < kMostTurn || cosine(m1, mean) < kMostTurn) return false;
  const bool flat_before = std::min(n0.norm(), n1.norm()) < 1e-4 * (pb - pa).squaredNorm();
  if (!flat_before && cosine(m0, m1) < std::min(0.9, cosine(n0, n1) - 0.05)) return false;
  CGAL::Euler::flip_edge(h, mesh);
  return true;
}

bool Editor::FlipTo(Edge e, double least_angle) {
  const Halfedge h = mesh.halfedge(e), o = mesh.opposite(h);
  const Vertex a = mesh.source(h), b = mesh.target(h), c = mesh.target(mesh.next(h)),
               d = mesh.target(mesh.next(o));
  if (c == d || mesh.degree(a) <= 4 || mesh.degree(b) <= 4 ||
      mesh.halfedge(c, d) != SurfaceMesh::null_halfedge())
    return false;
  const Vector3d &pa = mesh.point(a), &pb = mesh.point(b), &pc = mesh.point(c), &pd = mesh.point(d);
  if (std::min(MinAngle(pc, pd, pb), MinAngle(pd, pc, pa)) < least_angle) return false;
  const Vector3d mean = (pb - pa).cross(pc - pa) + (pa - pb).cross(pd - pb);
  const Vector3d m0 = (pd - pc).cross(pb - pc), m1 = (pc - pd).cross(pa - pd);
  if (m0.dot(mean) < 0.7 * m0.norm() * mean.norm() || m1.dot(mean) < 0.7 * m1.norm() * mean.norm())
    return false;
  CGAL::Euler::flip_edge(h, mesh);
  return true;
}

bool Editor::Move(Vertex v, const Vector3d& to) {
  if (!StarHolds(v, to, SurfaceMesh::null_vertex())) return false;
  mesh.point(v) = to;
  return true;
}

void Editor::MendThinFaces(double least_deg, int rounds) {
  const double least = least_deg * EIGEN_PI / 180;
  for (int round = 0; round < rounds; ++round) {
    std::vector<Face> thin;
    for (const Face f : mesh.faces())
      if (Angle(f) < least) thin.push_back(f);
    if (thin.empty()) return;
    for (const Face f : thin) {
      if (mesh.is_removed(f) || Angle(f) >= least) continue;
      std::array<Halfedge, 3> sides = {mesh.halfedge(f), mesh.next(mesh.halfedge(f)),
                                       mesh.prev(mesh.halfedge(f))};
      std::sort(sides.begin(), sides.end(), [&](Halfedge a, Halfedge b) {
        const double la = Length(mesh.edge(a)), lb = Length(mesh.edge(b));
        return la != lb ? la > lb : a < b;
      });
      if (Flip(mesh.edge(sides[0])) || Collapse(mesh.edge(sides[2]), 1e9)) continue;
      // The long side of an obtuse face cannot be flipped: move its obtuse corner away from that
      // side.
      const Vertex corner = mesh.target(mesh.next(sides[0]));
      Vector3d sum = Vector3d::Zero();
      int count = 0;
      for (const Halfedge h : CGAL::halfedges_around_target(mesh.halfedge(corner), mesh)) {
        sum += mesh.point(mesh.source(h));
        ++count;
      }
      if (!Move(corner, 0.5 * (mesh.point(corner) + sum / count)))
        Collapse(mesh.edge(sides[1]), 1e9);
    }
  }
}

}  // namespace keypose::cleanup
