#include "cleanup/adapt.h"

#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/Euler_operations.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <vector>

#include "cleanup/cgal_convert.h"
#include "core/geometry.h"
#include "core/parallel.h"
#include "core/ray_scene.h"

namespace keypose::cleanup {
namespace {

using Eigen::Vector3d;
using SurfaceMesh = CGAL::Surface_mesh<Vector3d>;
using Vertex = SurfaceMesh::Vertex_index;
using Edge = SurfaceMesh::Edge_index;
using Face = SurfaceMesh::Face_index;
using Halfedge = SurfaceMesh::Halfedge_index;

constexpr double kLong = 4.0 / 3, kShort = 4.0 / 5;      // of the wanted length: neither undoes the other
constexpr int kRounds = 6, kFits = 14, kLastFlips = 10;  // fits after which the edges stay
constexpr double kTurn = 0.3;                            // cosine beyond which a face may not turn in one step

double MinAngle(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const auto angle = [](const Vector3d& u, const Vector3d& v) { return std::atan2(u.cross(v).norm(), u.dot(v)); };
  return std::min({angle(b - a, c - a), angle(a - b, c - b), angle(a - c, b - c)});
}

// Edits that keep a closed manifold closed and no face turned over. Positions are the mesh's points; sizes ride along.
class Editor {
 public:
  explicit Editor(const Mesh& closed) : mesh(ToSurfaceMesh<SurfaceMesh>(closed)), sizes(mesh.number_of_vertices(), 1.0) {}

  SurfaceMesh mesh;
  std::vector<double> sizes;  // by vertex index

  double Length(Edge e) const { return (mesh.point(mesh.vertex(e, 0)) - mesh.point(mesh.vertex(e, 1))).norm(); }
  double Relative(Edge e) const { return Length(e) / (0.5 * (sizes[mesh.vertex(e, 0)] + sizes[mesh.vertex(e, 1)])); }
  Vertex Split(Edge e);
  bool Collapse(Edge e, double longest);
  bool Flip(Edge e);
  bool FlipTo(Edge e, double least_angle);
  bool Move(Vertex v, const Vector3d& to);
  Vector3d Cross(Face f) const;
  Vector3d Normal(Vertex v) const;
  double Angle(Face f) const;

 private:
  bool StarHolds(Vertex v, const Vector3d& to, Vertex ignored) const;
  double PlaneError(Vertex v, const Vector3d& x) const;
};

Vector3d Editor::Cross(Face f) const {
  const Halfedge h = mesh.halfedge(f);
  const Vector3d &a = mesh.point(mesh.source(h)), &b = mesh.point(mesh.target(h)), &c = mesh.point(mesh.target(mesh.next(h)));
  return (b - a).cross(c - a);
}

double Editor::Angle(Face f) const {
  const Halfedge h = mesh.halfedge(f);
  return MinAngle(mesh.point(mesh.source(h)), mesh.point(mesh.target(h)), mesh.point(mesh.target(mesh.next(h))));
}

Vector3d Editor::Normal(Vertex v) const {
  Vector3d sum = Vector3d::Zero();
  for (const Halfedge h : CGAL::halfedges_around_target(mesh.halfedge(v), mesh)) sum += Cross(mesh.face(h));
  return sum.normalized();
}

// Whether the faces around v, but those that also touch `ignored`, keep their side and an area when v moves.
bool Editor::StarHolds(Vertex v, const Vector3d& to, Vertex ignored) const {
  for (const Halfedge h : CGAL::halfedges_around_target(mesh.halfedge(v), mesh)) {
    const Vertex p = mesh.source(h), q = mesh.target(mesh.next(h));
    if (p == ignored || q == ignored) continue;
    const Vector3d &a = mesh.point(p), &b = mesh.point(q), &old = mesh.point(v);
    const Vector3d before = (old - a).cross(b - a), after = (to - a).cross(b - a);
    const double scale = (b - a).squaredNorm() + (to - a).squaredNorm();
    if (!(after.norm() > 1e-3 * scale)) {
      if (!(after.norm() > before.norm())) return false;  // a sliver may only get better
    }
    if (before.norm() > 1e-9 * scale && !(after.dot(before) > kTurn * after.norm() * before.norm())) return false;
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
  if (!CGAL::Euler::does_satisfy_link_condition(e, mesh) || mesh.number_of_faces() <= 4) return false;
  // A neck of three edges must not be closed, nor a vertex be left with two faces.
  if (mesh.degree(mesh.target(mesh.next(h))) <= 3 || mesh.degree(mesh.target(mesh.next(mesh.opposite(h)))) <= 3) return false;
  const Vector3d pa = mesh.point(a), pb = mesh.point(b);
  std::array<Vector3d, 3> places = {0.5 * (pa + pb), pa, pb};
  std::array<double, 3> errors;
  for (int i = 0; i < 3; ++i) errors[i] = PlaneError(a, places[i]) + PlaneError(b, places[i]);
  std::array<int, 3> order = {0, 1, 2};
  // The middle is best for the triangles: an end must be clearly better for the shape.
  errors[0] *= 0.5;
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return errors[i] < errors[j]; });
  const double size = 0.5 * (sizes[a] + sizes[b]);
  for (const int i : order) {
    if (!StarHolds(a, places[i], b) || !StarHolds(b, places[i], a)) continue;
    bool fits = true;
    for (const Vertex v : {a, b})
      for (const Halfedge g : CGAL::halfedges_around_target(mesh.halfedge(v), mesh)) {
        const Vertex w = mesh.source(g);
        if (w != a && w != b && (mesh.point(w) - places[i]).norm() > longest * 0.5 * (size + sizes[w])) fits = false;
      }
    if (!fits) continue;
    const Vertex kept = CGAL::Euler::collapse_edge(e, mesh);
    mesh.point(kept) = places[i];
    sizes[kept] = size;
    return true;
  }
  return false;
}

// When the smaller angle of the two faces grows and the fold between them does not.
bool Editor::Flip(Edge e) {
  const Halfedge h = mesh.halfedge(e), o = mesh.opposite(h);
  const Vertex a = mesh.source(h), b = mesh.target(h), c = mesh.target(mesh.next(h)), d = mesh.target(mesh.next(o));
  if (c == d || mesh.degree(a) <= 3 || mesh.degree(b) <= 3 || mesh.halfedge(c, d) != SurfaceMesh::null_halfedge()) return false;
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
  if (cosine(m0, mean) < kTurn || cosine(m1, mean) < kTurn) return false;
  const bool flat_before = std::min(n0.norm(), n1.norm()) < 1e-4 * (pb - pa).squaredNorm();
  if (!flat_before && cosine(m0, m1) < std::min(0.9, cosine(n0, n1) - 0.05)) return false;
  CGAL::Euler::flip_edge(h, mesh);
  return true;
}

// When the other diagonal can be: no angle below the least, no face turned.
bool Editor::FlipTo(Edge e, double least_angle) {
  const Halfedge h = mesh.halfedge(e), o = mesh.opposite(h);
  const Vertex a = mesh.source(h), b = mesh.target(h), c = mesh.target(mesh.next(h)), d = mesh.target(mesh.next(o));
  if (c == d || mesh.degree(a) <= 4 || mesh.degree(b) <= 4 || mesh.halfedge(c, d) != SurfaceMesh::null_halfedge()) return false;
  const Vector3d &pa = mesh.point(a), &pb = mesh.point(b), &pc = mesh.point(c), &pd = mesh.point(d);
  if (std::min(MinAngle(pc, pd, pb), MinAngle(pd, pc, pa)) < least_angle) return false;
  const Vector3d mean = (pb - pa).cross(pc - pa) + (pa - pb).cross(pd - pb);
  const Vector3d m0 = (pd - pc).cross(pb - pc), m1 = (pc - pd).cross(pa - pd);
  if (m0.dot(mean) < 0.7 * m0.norm() * mean.norm() || m1.dot(mean) < 0.7 * m1.norm() * mean.norm()) return false;
  CGAL::Euler::flip_edge(h, mesh);
  return true;
}

bool Editor::Move(Vertex v, const Vector3d& to) {
  if (!StarHolds(v, to, SurfaceMesh::null_vertex())) return false;
  mesh.point(v) = to;
  return true;
}

// The loop: a mesh that is edited, the surface it stays on, and the sizes there.
class Remesher {
 public:
  Remesher(const Mesh& start, const Mesh& surface, const Eigen::VectorXd& sizes)
      : editor_(start),
        mesh_(editor_.mesh),
        surface_(surface),
        scene_(surface.points, surface.faces),
        normals_(FaceNormals(surface.points, surface.faces)),
        wanted_(sizes) {}

  Mesh Run(int faces);

 private:
  void SplitLong();
  void CollapseShort();
  void FlipAll();
  void Relax(double step);
  void TakeSizes();
  void Fit();
  void FixCount(int faces);
  void FlipForShape();
  void MoveAll(const std::vector<Vertex>& vertices, const std::vector<Vector3d>& to);
  std::vector<Vertex> Vertices() const { return {mesh_.vertices().begin(), mesh_.vertices().end()}; }
  std::array<Vertex, 3> Corners(Face f) const {
    const Halfedge h = mesh_.halfedge(f);
    return {mesh_.source(h), mesh_.target(h), mesh_.target(mesh_.next(h))};
  }
  bool Agrees(const RayScene::Foot& foot, const Vector3d& normal) const {
    return foot.face >= 0 && normals_.row(foot.face).dot(normal.transpose()) > 0;
  }

  Editor editor_;
  SurfaceMesh& mesh_;
  const Mesh& surface_;
  const RayScene scene_;
  const PointsX3 normals_;
  const Eigen::VectorXd& wanted_;
  double scale_ = 1;
};

void Remesher::SplitLong() {
  const std::vector<Edge> edges(mesh_.edges().begin(), mesh_.edges().end());
  for (const Edge e : edges)
    if (editor_.Relative(e) > kLong) editor_.Split(e);
}

void Remesher::CollapseShort() {
  const std::vector<Edge> edges(mesh_.edges().begin(), mesh_.edges().end());
  for (const Edge e : edges)
    if (!mesh_.is_removed(e) && editor_.Relative(e) < kShort) editor_.Collapse(e, kLong);
}

void Remesher::FlipAll() {
  for (const Edge e : mesh_.edges()) editor_.Flip(e);
}

void Remesher::MoveAll(const std::vector<Vertex>& vertices, const std::vector<Vector3d>& to) {
  for (std::size_t i = 0; i < vertices.size(); ++i) editor_.Move(vertices[i], to[i]);
}

// Each vertex slides to the middle of its fan, larger faces pulling more, and back to the surface straight below.
void Remesher::Relax(double step) {
  const std::vector<Vertex> vertices = Vertices();
  std::vector<Vector3d> to(vertices.size());
  ParallelFor(
      static_cast<std::int64_t>(vertices.size()),
      [&](std::int64_t i) {
        const Vertex v = vertices[i];
        const Vector3d x = mesh_.point(v), normal = editor_.Normal(v);
        Vector3d sum = Vector3d::Zero();
        double weights = 0;
        for (const Halfedge h : CGAL::halfedges_around_target(mesh_.halfedge(v), mesh_)) {
          const Vertex p = mesh_.source(h), q = mesh_.target(mesh_.next(h));
          const double size = (editor_.sizes[v] + editor_.sizes[p] + editor_.sizes[q]) / 3;
          const double weight = editor_.Cross(mesh_.face(h)).norm() / (size * size);
          sum += weight * (x + mesh_.point(p) + mesh_.point(q)) / 3;
          weights += weight;
        }
        Vector3d move = weights > 0 ? Vector3d(step * (sum / weights - x)) : Vector3d::Zero();
        move -= normal * normal.dot(move);
        const RayScene::Foot foot = scene_.ClosestPoint(x + move, 2 * editor_.sizes[v]);
        to[i] = Agrees(foot, normal) ? foot.point : x;
      },
      128);
  MoveAll(vertices, to);
}

void Remesher::TakeSizes() {
  const std::vector<Vertex> vertices = Vertices();
  editor_.sizes.resize(mesh_.num_vertices());
  ParallelFor(
      static_cast<std::int64_t>(vertices.size()),
      [&](std::int64_t i) {
        const RayScene::Foot foot = scene_.ClosestPoint(mesh_.point(vertices[i]));
        double size = 0;
        for (int k = 0; k < 3; ++k) size += foot.barycentric[k] * wanted_[surface_.faces(foot.face, k)];
        editor_.sizes[vertices[i]] = scale_ * size;
      },
      128);
}

// What a point of a face is off from the surface: along the surface's normal there, by how much.
struct Miss {
  Vector3d normal = Vector3d::Zero();
  double distance = 0;
};

// Corners on a sphere leave every face inside of it, and corners beside an edge cut it off. Each corner moves to where the points of its
// faces are nearest to the planes of the surface below them, least squares with a pull to stay; neighbours move as well, hence the damping.
void Remesher::Fit() {
  constexpr double kPull = 0.02, kDamping = 0.5, kMostOverSize = 0.25;
  const double shares[4][3] = {{1. / 3, 1. / 3, 1. / 3}, {2. / 3, 1. / 6, 1. / 6}, {1. / 6, 2. / 3, 1. / 6}, {1. / 6, 1. / 6, 2. / 3}};
  const std::vector<Face> faces(mesh_.faces().begin(), mesh_.faces().end());
  std::vector<std::array<Miss, 4>> misses(mesh_.num_faces());
  ParallelFor(
      static_cast<std::int64_t>(faces.size()),
      [&](std::int64_t i) {
        const std::array<Vertex, 3> c = Corners(faces[i]);
        const Vector3d normal = editor_.Cross(faces[i]).normalized();
        for (int k = 0; k < 4; ++k) {
          const Vector3d x = shares[k][0] * mesh_.point(c[0]) + shares[k][1] * mesh_.point(c[1]) + shares[k][2] * mesh_.point(c[2]);
          const RayScene::Foot foot = scene_.ClosestPoint(x, editor_.sizes[c[0]]);
          if (!Agrees(foot, normal)) continue;
          const Vector3d n = normals_.row(foot.face).transpose();
          misses[faces[i]][k] = {n, n.dot(foot.point - x)};
        }
      },
      128);
  const std::vector<Vertex> vertices = Vertices();
  std::vector<Vector3d> to;
  for (const Vertex v : vertices) {
    Eigen::Matrix3d system = Eigen::Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    for (const Halfedge h : CGAL::halfedges_around_target(mesh_.halfedge(v), mesh_)) {
      const std::array<Vertex, 3> c = Corners(mesh_.face(h));
      const int corner = c[0] == v ? 0 : c[1] == v ? 1 : 2;
      const double area = editor_.Cross(mesh_.face(h)).norm();
      for (int k = 0; k < 4; ++k) {
        const Miss& miss = misses[mesh_.face(h)][k];
        const double share = shares[k][corner];
        system += area * share * share * miss.normal * miss.normal.transpose();
        right += area * share * miss.distance * miss.normal;
      }
    }
    system += (kPull * system.trace() + 1e-30) * Eigen::Matrix3d::Identity();
    Vector3d move = kDamping * system.ldlt().solve(right);
    const double most = kMostOverSize * editor_.sizes[v];
    if (move.norm() > most) move *= most / move.norm();
    to.push_back(mesh_.point(v) + move);
  }
  MoveAll(vertices, to);
}

// Edges that run across a ridge are turned along it: where the other diagonal's middle is much nearer to the surface.
void Remesher::FlipForShape() {
  constexpr double kGain = 0.5, kLeastAngle = 20 * EIGEN_PI / 180;
  const std::vector<Edge> edges(mesh_.edges().begin(), mesh_.edges().end());
  std::vector<std::array<double, 2>> misses(edges.size());
  const auto other = [&](Halfedge h) { return mesh_.target(mesh_.next(h)); };
  ParallelFor(
      static_cast<std::int64_t>(edges.size()),
      [&](std::int64_t i) {
        const Halfedge h = mesh_.halfedge(edges[i]);
        const Vector3d now = 0.5 * (mesh_.point(mesh_.source(h)) + mesh_.point(mesh_.target(h)));
        const Vector3d then = 0.5 * (mesh_.point(other(h)) + mesh_.point(other(mesh_.opposite(h))));
        misses[i] = {scene_.ClosestPoint(now).squared_distance, scene_.ClosestPoint(then).squared_distance};
      },
      128);
  std::vector<char> touched(mesh_.num_faces(), 0);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Halfedge h = mesh_.halfedge(edges[i]);
    const Face f = mesh_.face(h), g = mesh_.face(mesh_.opposite(h));
    if (!(misses[i][1] < kGain * misses[i][0]) || touched[f] || touched[g]) continue;
    if (editor_.FlipTo(edges[i], kLeastAngle)) touched[f] = touched[g] = 1;
  }
}

struct Candidate {
  double relative;
  Edge edge;
  bool operator<(const Candidate& o) const { return relative != o.relative ? relative < o.relative : edge < o.edge; }
};

// Shortest first down, longest first up; lengths over the wanted ones.
void Remesher::FixCount(int faces) {
  for (int pass = 0; pass < 12 && static_cast<int>(mesh_.number_of_faces()) > faces + 1; ++pass) {
    std::vector<Candidate> edges;
    for (const Edge e : mesh_.edges()) edges.push_back({editor_.Relative(e), e});
    std::sort(edges.begin(), edges.end());
    // Lengths around a collapse change, so a pass takes a few only.
    std::size_t budget = std::max<std::size_t>(50, edges.size() / 20);
    for (const Candidate& c : edges) {
      if (budget == 0 || static_cast<int>(mesh_.number_of_faces()) <= faces + 1) break;
      if (!mesh_.is_removed(c.edge) && editor_.Collapse(c.edge, 1e9)) --budget;
    }
  }
  std::priority_queue<Candidate> longest;
  const auto add = [&](Edge e) { longest.push({editor_.Relative(e), e}); };
  for (const Edge e : mesh_.edges()) add(e);
  while (static_cast<int>(mesh_.number_of_faces()) + 1 < faces) {
    const auto [relative, e] = longest.top();
    longest.pop();
    if (editor_.Relative(e) < relative) continue;  // split since
    const Vertex middle = editor_.Split(e);
    for (const Halfedge h : CGAL::halfedges_around_target(mesh_.halfedge(middle), mesh_)) add(mesh_.edge(h));
  }
}

void MendThinFaces(Editor& editor, double least_deg, int rounds) {
  SurfaceMesh& mesh = editor.mesh;
  const double least = least_deg * EIGEN_PI / 180;
  for (int round = 0; round < rounds; ++round) {
    std::vector<Face> thin;
    for (const Face f : mesh.faces())
      if (editor.Angle(f) < least) thin.push_back(f);
    if (thin.empty()) return;
    for (const Face f : thin) {
      if (mesh.is_removed(f) || editor.Angle(f) >= least) continue;
      std::array<Halfedge, 3> sides = {mesh.halfedge(f), mesh.next(mesh.halfedge(f)), mesh.prev(mesh.halfedge(f))};
      std::sort(sides.begin(), sides.end(), [&](Halfedge a, Halfedge b) {
        const double la = editor.Length(mesh.edge(a)), lb = editor.Length(mesh.edge(b));
        return la != lb ? la > lb : a < b;
      });
      if (editor.Flip(mesh.edge(sides[0])) || editor.Collapse(mesh.edge(sides[2]), 1e9)) continue;
      // A cap whose long side cannot be flipped: its blunt corner moves away from that side.
      const Vertex corner = mesh.target(mesh.next(sides[0]));
      Vector3d sum = Vector3d::Zero();
      int count = 0;
      for (const Halfedge h : CGAL::halfedges_around_target(mesh.halfedge(corner), mesh)) sum += mesh.point(mesh.source(h)), ++count;
      if (!editor.Move(corner, 0.5 * (mesh.point(corner) + sum / count))) editor.Collapse(mesh.edge(sides[1]), 1e9);
    }
  }
}

Mesh Remesher::Run(int faces) {
  TakeSizes();
  for (int round = 0; round < kRounds; ++round) {
    SplitLong();
    CollapseShort();
    FlipAll();
    Relax(0.8);
    FlipAll();
    Relax(0.8);
    mesh_.collect_garbage();
    const double off = std::sqrt(static_cast<double>(mesh_.number_of_faces()) / faces);
    if (round + 1 < kRounds) scale_ *= std::clamp(off, 0.5, 2.0);
    TakeSizes();
  }
  for (int round = 0; round < 2; ++round) {
    FixCount(faces);
    FlipAll();
    Relax(0.8);
    MendThinFaces(editor_, 20, 4);
    mesh_.collect_garbage();
    TakeSizes();
  }
  FixCount(faces);
  MendThinFaces(editor_, 10, 6);
  for (int round = 0; round < kFits; ++round) {
    if (round % 2 == 1 && round < kLastFlips) FlipForShape();
    Fit();
  }
  MendThinFaces(editor_, 5, 6);
  mesh_.collect_garbage();
  return FromSurfaceMesh(mesh_);
}

}  // namespace

Mesh Remeshed(const Mesh& start, const Mesh& surface, const Eigen::VectorXd& sizes, int faces) {
  return Remesher(start, surface, sizes).Run(faces);
}

Mesh WithoutThinAngles(const Mesh& closed, double least_deg) {
  Editor editor(closed);
  MendThinFaces(editor, least_deg, 10);
  editor.mesh.collect_garbage();
  return FromSurfaceMesh(editor.mesh);
}

Mesh SplitTo(const Mesh& closed, int faces) {
  Editor editor(closed);
  std::priority_queue<Candidate> longest;
  for (const Edge e : editor.mesh.edges()) longest.push({editor.Length(e), e});
  while (static_cast<int>(editor.mesh.number_of_faces()) + 1 < faces) {
    const auto [length, e] = longest.top();
    longest.pop();
    if (editor.Length(e) < length) continue;  // split since
    const Vertex middle = editor.Split(e);
    for (const Halfedge h : CGAL::halfedges_around_target(editor.mesh.halfedge(middle), editor.mesh))
      longest.push({editor.Length(editor.mesh.edge(h)), editor.mesh.edge(h)});
  }
  return FromSurfaceMesh(editor.mesh);
}

}  // namespace keypose::cleanup
