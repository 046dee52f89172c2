#include "cleanup/editing/adapt.h"

#include <CGAL/Surface_mesh.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <queue>
#include <vector>

#include "cleanup/editing/cgal_convert.h"
#include "cleanup/editing/mesh_editor.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/tuned.h"

namespace keypose::cleanup {
namespace {

using Eigen::Vector3d;

constexpr double
    kLong = 4.0 / 3,
    kShort = 4.0 /
             5;  // of the wanted length: chosen so that splits and collapses do not undo each other
constexpr int kRounds = 6, kFits = 14,
              kLastFlips = 12;  // fits after which edges are not flipped any more

// Tuned on the surfaces of the skull and the plush dog at 20,000 faces, by the distance in pixel
// footprints and the least angles (docs/results/cleanup.md).
struct RemeshTuning {
  // Of the fits.
  KEYPOSE_TUNED(double, kPull, 0.02);          // share of the system's trace that holds a vertex
  KEYPOSE_TUNED(double, kDamping, 0.5);        // share of a vertex's move that is made
  KEYPOSE_TUNED(double, kMostOverSize, 0.25);  // longest move, of the wanted edge length
  KEYPOSE_TUNED(double, kSlide, 2);          // strength of the slide, in moves to the fan's centre
  KEYPOSE_TUNED(double, kThinDeg, 35);       // degrees: vertices at smaller angles slide
  KEYPOSE_TUNED(double, kThinRangeDeg, 15);  // degrees below kThinDeg where the slide is full
  // Of the flips.
  KEYPOSE_TUNED(double, kGain, 0.9);        // share of the cost that a flip must come below
  KEYPOSE_TUNED(double, kAngleWeight, 40);  // cost of an angle of 0, in median squared distances
  KEYPOSE_TUNED(double, kGoodAngle, 35 * EIGEN_PI / 180);   // rad: larger angles cost nothing
  KEYPOSE_TUNED(double, kLeastAngle, 20 * EIGEN_PI / 180);  // rad: no flip makes a smaller one
};

// Distance of a point of a face from the surface, along the surface's normal there.
struct SurfaceOffset {
  Vector3d normal = Vector3d::Zero();
  double distance = 0;
};

// The state of remeshing: the edited mesh, the surface that it stays on, and the wanted sizes.
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
  Vector3d ToMiddle(Vertex v) const;
  void Relax(double step);
  void TakeSizes();
  std::vector<std::array<SurfaceOffset, 4>> SurfaceOffsets() const;
  Vector3d FittedPlace(Vertex v, const std::vector<std::array<SurfaceOffset, 4>>& offsets) const;
  void Fit();
  std::vector<std::array<double, 2>> DiagonalOffsets(const std::vector<Edge>& edges) const;
  void FixCount(int faces);
  void FlipForShape();
  void MoveAll(const std::vector<Vertex>& vertices, const std::vector<Vector3d>& to);
  std::vector<Vertex> Vertices() const {
    return {mesh_.vertices().begin(), mesh_.vertices().end()};
  }
  std::array<Vertex, 3> Corners(Face f) const {
    const Halfedge h = mesh_.halfedge(f);
    return {mesh_.source(h), mesh_.target(h), mesh_.target(mesh_.next(h))};
  }
  // The ends of an edge, then the tips of its two faces.
  std::array<Vector3d, 4> Diamond(Edge e) const {
    const Halfedge h = mesh_.halfedge(e), o = mesh_.opposite(h);
    return {mesh_.point(mesh_.source(h)), mesh_.point(mesh_.target(h)),
            mesh_.point(mesh_.target(mesh_.next(h))), mesh_.point(mesh_.target(mesh_.next(o)))};
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

// The move along the surface to the centre of the fan. Faces are weighted by their area relative to
// the wanted size.
Vector3d Remesher::ToMiddle(Vertex v) const {
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
  const Vector3d move = weights > 0 ? Vector3d(sum / weights - x) : Vector3d::Zero();
  return move - normal * normal.dot(move);
}

// Moves each vertex towards the centre of its fan, and then to the closest point of the surface.
void Remesher::Relax(double step) {
  const std::vector<Vertex> vertices = Vertices();
  std::vector<Vector3d> to(vertices.size());
  ParallelFor(
      std::ssize(vertices),
      [&](std::int64_t i) {
        const Vertex v = vertices[i];
        const Vector3d x = mesh_.point(v);
        const RayScene::Foot foot =
            scene_.ClosestPoint(x + step * ToMiddle(v), 2 * editor_.sizes[v]);
        to[i] = Agrees(foot, editor_.Normal(v)) ? foot.point : x;
      },
      128);
  MoveAll(vertices, to);
}

void Remesher::TakeSizes() {
  const std::vector<Vertex> vertices = Vertices();
  editor_.sizes.resize(mesh_.num_vertices());
  ParallelFor(
      std::ssize(vertices),
      [&](std::int64_t i) {
        const RayScene::Foot foot = scene_.ClosestPoint(mesh_.point(vertices[i]));
        double size = 0;
        for (int k = 0; k < 3; ++k)
          size += foot.barycentric[k] * wanted_[surface_.faces(foot.face, k)];
        editor_.sizes[vertices[i]] = scale_ * size;
      },
      128);
}

// Barycentric coordinates of the points where a face is compared with the surface.
constexpr double kShares[4][3] = {{1. / 3, 1. / 3, 1. / 3},
                                  {2. / 3, 1. / 6, 1. / 6},
                                  {1. / 6, 2. / 3, 1. / 6},
                                  {1. / 6, 1. / 6, 2. / 3}};

std::vector<std::array<SurfaceOffset, 4>> Remesher::SurfaceOffsets() const {
  const std::vector<Face> faces(mesh_.faces().begin(), mesh_.faces().end());
  std::vector<std::array<SurfaceOffset, 4>> offsets(mesh_.num_faces());
  ParallelFor(
      std::ssize(faces),
      [&](std::int64_t i) {
        const std::array<Vertex, 3> c = Corners(faces[i]);
        const Vector3d normal = editor_.Cross(faces[i]).normalized();
        for (int k = 0; k < 4; ++k) {
          const Vector3d x = kShares[k][0] * mesh_.point(c[0]) + kShares[k][1] * mesh_.point(c[1]) +
                             kShares[k][2] * mesh_.point(c[2]);
          const RayScene::Foot foot = scene_.ClosestPoint(x, editor_.sizes[c[0]]);
          if (!Agrees(foot, normal)) continue;
          const Vector3d n = normals_.row(foot.face).transpose();
          offsets[faces[i]][k] = {n, n.dot(foot.point - x)};
        }
      },
      128);
  return offsets;
}

// If all vertices lie on a sphere, the faces lie inside of it, and vertices beside a sharp edge cut
// it off. So each vertex moves to where the points of its faces are nearest to the planes of the
// surface below them, in the sense of least squares. A small weight holds it in place, and the move
// is damped because the neighbours move as well. If a face at the vertex is thin, the weight also
// pulls along the surface to the centre of the fan. This pull prevails where the surface is flat
// and the position of the vertex on it does not matter.
Vector3d Remesher::FittedPlace(Vertex v,
                               const std::vector<std::array<SurfaceOffset, 4>>& offsets) const {
  using Tuning = RemeshTuning;
  Eigen::Matrix3d system = Eigen::Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const Halfedge h : CGAL::halfedges_around_target(mesh_.halfedge(v), mesh_)) {
    const std::array<Vertex, 3> c = Corners(mesh_.face(h));
    int corner = 2;
    if (c[1] == v) corner = 1;
    if (c[0] == v) corner = 0;
    const double area = editor_.Cross(mesh_.face(h)).norm();
    for (int k = 0; k < 4; ++k) {
      const SurfaceOffset& offset = offsets[mesh_.face(h)][k];
      const double share = kShares[k][corner];
      system += area * share * share * offset.normal * offset.normal.transpose();
      right += area * share * offset.distance * offset.normal;
    }
  }
  const double pull = Tuning::kPull * system.trace() + 1e-30;
  system += pull * Eigen::Matrix3d::Identity();
  const double thin = std::clamp<double>(
      (Tuning::kThinDeg - editor_.Angle(v) * 180 / EIGEN_PI) / Tuning::kThinRangeDeg, 0, 1);
  const auto solver = system.ldlt();
  // Applied through the inverse twice, so that a vertex on a sharp edge only moves along it.
  if (thin > 0) right += pull * pull * Tuning::kSlide * thin * solver.solve(ToMiddle(v));
  Vector3d move = Tuning::kDamping * solver.solve(right);
  const double most = Tuning::kMostOverSize * editor_.sizes[v];
  if (move.norm() > most) move *= most / move.norm();
  return mesh_.point(v) + move;
}

void Remesher::Fit() {
  const std::vector<std::array<SurfaceOffset, 4>> offsets = SurfaceOffsets();
  const std::vector<Vertex> vertices = Vertices();
  std::vector<Vector3d> to(vertices.size());
  ParallelFor(
      std::ssize(vertices), [&](std::int64_t i) { to[i] = FittedPlace(vertices[i], offsets); },
      128);
  MoveAll(vertices, to);
}

// For each edge, the squared distances from the surface of its midpoint and of the other diagonal's
// midpoint.
std::vector<std::array<double, 2>> Remesher::DiagonalOffsets(const std::vector<Edge>& edges) const {
  std::vector<std::array<double, 2>> offsets(edges.size());
  ParallelFor(
      std::ssize(edges),
      [&](std::int64_t i) {
        const std::array<Vector3d, 4> p = Diamond(edges[i]);
        offsets[i] = {scene_.ClosestPoint(0.5 * (p[0] + p[1])).squared_distance,
                      scene_.ClosestPoint(0.5 * (p[2] + p[3])).squared_distance};
      },
      128);
  return offsets;
}

// Flips edges across a ridge to run along it, and edges between thin faces to improve their angles.
// An edge is flipped if that lowers its cost: the squared distance from the surface plus a penalty
// for small angles, which is scaled by the median distance.
void Remesher::FlipForShape() {
  using Tuning = RemeshTuning;
  const std::vector<Edge> edges(mesh_.edges().begin(), mesh_.edges().end());
  const std::vector<std::array<double, 2>> offsets = DiagonalOffsets(edges);
  std::vector<double> now(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) now[i] = offsets[i][0];
  const double weight = Tuning::kAngleWeight * UpperMedian(std::move(now));
  const auto lack = [&](double angle) {
    return weight * std::pow(std::max(0.0, 1 - angle / Tuning::kGoodAngle), 2);
  };
  std::vector<char> touched(mesh_.num_faces(), 0);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Halfedge h = mesh_.halfedge(edges[i]);
    const Face f = mesh_.face(h), g = mesh_.face(mesh_.opposite(h));
    if (touched[f] || touched[g]) continue;
    const auto [a, b, c, d] = Diamond(edges[i]);
    const double left = MinAngle(a, b, c), right = MinAngle(b, a, d);
    const double cost = offsets[i][0] + lack(left) + lack(right);
    if (!(offsets[i][1] + lack(MinAngle(c, d, b)) + lack(MinAngle(d, c, a)) < Tuning::kGain * cost))
      continue;
    if (editor_.FlipTo(edges[i], std::min({Tuning::kLeastAngle, left, right})))
      touched[f] = touched[g] = 1;
  }
}

struct Candidate {
  double relative;
  Edge edge;
  bool operator<(const Candidate& o) const {
    return relative != o.relative ? relative < o.relative : edge < o.edge;
  }
};

// Collapses the shortest edges first, or splits the longest first, by length over wanted length.
void Remesher::FixCount(int faces) {
  for (int pass = 0; pass < 12 && static_cast<int>(mesh_.number_of_faces()) > faces + 1; ++pass) {
    std::vector<Candidate> edges;
    for (const Edge e : mesh_.edges()) edges.push_back({editor_.Relative(e), e});
    std::sort(edges.begin(), edges.end());
    // Lengths around a collapse change, so one pass collapses only a few.
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
    for (const Halfedge h : CGAL::halfedges_around_target(mesh_.halfedge(middle), mesh_))
      add(mesh_.edge(h));
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
    editor_.MendThinFaces(20, 4);
    mesh_.collect_garbage();
    TakeSizes();
  }
  FixCount(faces);
  editor_.MendThinFaces(10, 6);
  for (int round = 0; round < kFits; ++round) {
    if (round % 2 == 1 && round < kLastFlips) FlipForShape();
    Fit();
  }
  editor_.MendThinFaces(5, 6);
  mesh_.collect_garbage();
  return FromSurfaceMesh(mesh_);
}

}  // namespace

Mesh Remeshed(const Mesh& start, const Mesh& surface, const Eigen::VectorXd& sizes, int faces) {
  return Remesher(start, surface, sizes).Run(faces);
}

Mesh WithoutThinAngles(const Mesh& closed, double least_deg) {
  Editor editor(closed);
  editor.MendThinFaces(least_deg, 10);
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
    for (const Halfedge h :
         CGAL::halfedges_around_target(editor.mesh.halfedge(middle), editor.mesh))
      longest.push({editor.Length(editor.mesh.edge(h)), editor.mesh.edge(h)});
  }
  return FromSurfaceMesh(editor.mesh);
}

}  // namespace keypose::cleanup
