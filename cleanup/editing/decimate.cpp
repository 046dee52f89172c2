#include "cleanup/editing/decimate.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"

namespace keypose::cleanup {
namespace {

using Eigen::Vector3d;

constexpr double kTurn = 0.3;  // smallest cosine of the angle by which a collapse may turn a face
// weight of the squared edge length in the cost, so that flat places get even triangles
constexpr double kShape = 1e-3;
constexpr double kPassShare = 0.4;  // of the edges, the cheapest ones, are tried in one pass

// x^T A x + 2 b^T x + c: squared distances to planes, weighted by area.
struct Quadric {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  double c = 0;
  void Add(const Quadric& o) {
    a += o.a;
    b += o.b;
    c += o.c;
  }
  double At(const Vector3d& x) const { return x.dot(a * x) + 2 * b.dot(x) + c; }
};

struct Collapse {
  float cost;
  int a, b;
  bool operator<(const Collapse& o) const {
    if (cost != o.cost) return cost < o.cost;
    if (a != o.a) return a < o.a;
    return b < o.b;
  }
};

class Decimation {
 public:
  explicit Decimation(const Mesh& mesh);
  Mesh Run(int faces);

 private:
  void BuildFans();
  std::vector<Collapse> Candidates() const;
  Vector3d Place(int a, int b) const;
  int Pass(int faces);
  bool Allowed(int a, int b, const Vector3d& x) const;
  bool StarHolds(int v, int other, const Vector3d& x) const;
  std::vector<int> Ring(int v) const;
  void Do(int a, int b, const Vector3d& x);

  PointsX3 points_;
  std::vector<Eigen::Vector3i> faces_;
  std::vector<Quadric> quadrics_;
  std::vector<char> border_, touched_;
  std::vector<int> begin_, fan_;  // faces of each vertex; rebuilt at the start of each pass
  int alive_ = 0;
};

Decimation::Decimation(const Mesh& mesh)
    : points_(mesh.points), faces_(mesh.face_count()), quadrics_(mesh.vertex_count()) {
  for (int f = 0; f < mesh.face_count(); ++f) faces_[f] = mesh.faces.row(f).transpose();
  border_ = BoundaryVertices(mesh.vertex_count(), mesh.faces);
  alive_ = mesh.face_count();
  for (const Eigen::Vector3i& t : faces_) {
    const Vector3d p = points_.row(t[0]), q = points_.row(t[1]), r = points_.row(t[2]);
    const Vector3d cross = (q - p).cross(r - p);
    const double twice = cross.norm();
    if (!(twice > 0)) continue;
    const Vector3d n = cross / twice;
    Quadric plane;
    plane.a = twice * n * n.transpose();
    plane.b = -twice * n.dot(p) * n;
    plane.c = twice * n.dot(p) * n.dot(p);
    for (int k = 0; k < 3; ++k) quadrics_[t[k]].Add(plane);
  }
}

void Decimation::BuildFans() {
  const int vertices = static_cast<int>(points_.rows());
  begin_.assign(vertices + 1, 0);
  for (const Eigen::Vector3i& t : faces_)
    for (int k = 0; k < 3; ++k) ++begin_[t[k] + 1];
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  fan_.resize(3 * faces_.size());
  std::vector<int> at(begin_.begin(), begin_.end() - 1);
  for (int f = 0; f < std::ssize(faces_); ++f)
    for (int k = 0; k < 3; ++k) fan_[at[faces_[f][k]]++] = f;
}

// The best position of the joined vertex; the midpoint where the surface is too flat to determine
// one. Coordinates are relative to the midpoint, because the quadric suffers from cancellation far
// from the origin.
Vector3d Decimation::Place(int a, int b) const {
  const Vector3d pa = points_.row(a), pb = points_.row(b), middle = 0.5 * (pa + pb);
  Quadric q = quadrics_[a];
  q.Add(quadrics_[b]);
  const double length = (pb - pa).norm(), trace = q.a.trace();
  if (!(trace > 0)) return middle;
  const Eigen::Matrix3d system = q.a + 1e-3 * trace * Eigen::Matrix3d::Identity();
  const Vector3d move = -system.ldlt().solve(q.a * middle + q.b);
  return move.norm() < length ? Vector3d(middle + move) : middle;
}

std::vector<Collapse> Decimation::Candidates() const {
  std::vector<Collapse> all(3 * faces_.size());
  ParallelFor(
      std::ssize(faces_),
      [&](std::int64_t f) {
        for (int k = 0; k < 3; ++k) {
          const int a = faces_[f][k], b = faces_[f][(k + 1) % 3];
          Collapse& c = all[3 * f + k];
          c = {-1, a, b};
          if (a > b || border_[a] || border_[b])
            continue;  // the other face of the edge has it in the opposite direction
          const Vector3d x = Place(a, b);
          const double squared = (points_.row(a) - points_.row(b)).squaredNorm();
          const double area = quadrics_[a].a.trace() + quadrics_[b].a.trace();
          c.cost = static_cast<float>(std::max(0.0, quadrics_[a].At(x) + quadrics_[b].At(x)) +
                                      kShape * squared * (area + squared));
        }
      },
      1024);
  std::erase_if(all, [](const Collapse& c) { return c.cost < 0; });
  const auto share = static_cast<std::ptrdiff_t>(kPassShare * static_cast<double>(all.size()));
  std::nth_element(all.begin(), all.begin() + share, all.end());
  all.resize(static_cast<std::size_t>(share));
  std::sort(all.begin(), all.end());
  return all;
}

std::vector<int> Decimation::Ring(int v) const {
  std::vector<int> ring;
  for (int i = begin_[v]; i < begin_[v + 1]; ++i)
    for (int k = 0; k < 3; ++k)
      if (const int w = faces_[fan_[i]][k]; w != v) ring.push_back(w);
  std::sort(ring.begin(), ring.end());
  ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
  return ring;
}

bool Decimation::StarHolds(int v, int other, const Vector3d& x) const {
  for (int i = begin_[v]; i < begin_[v + 1]; ++i) {
    const Eigen::Vector3i& t = faces_[fan_[i]];
    if (t[0] == other || t[1] == other || t[2] == other) continue;
    int k = 2;
    if (t[1] == v) k = 1;
    if (t[0] == v) k = 0;
    const Vector3d p = points_.row(t[(k + 1) % 3]), q = points_.row(t[(k + 2) % 3]),
                   old = points_.row(v);
    const Vector3d before = (p - old).cross(q - old), after = (p - x).cross(q - x);
    const double longest =
        std::max({(p - x).squaredNorm(), (q - x).squaredNorm(), (p - q).squaredNorm()});
    if (!(after.norm() > 0.03 * longest) && !(after.norm() > before.norm())) return false;
    if (before.norm() > 1e-9 * longest &&
        !(after.dot(before) > kTurn * after.norm() * before.norm()))
      return false;
  }
  return true;
}

// The link condition of an inner edge: the rings of its ends share only the two opposite vertices
// of its faces.
bool Decimation::Allowed(int a, int b, const Vector3d& x) const {
  const std::vector<int> ra = Ring(a), rb = Ring(b);
  std::vector<int> common;
  std::set_intersection(ra.begin(), ra.end(), rb.begin(), rb.end(), std::back_inserter(common));
  if (common.size() != 2 || ra.size() + rb.size() < 7) return false;
  for (const int tip : common)
    if (begin_[tip + 1] - begin_[tip] <= 3) return false;
  return StarHolds(a, b, x) && StarHolds(b, a, x);
}

void Decimation::Do(int a, int b, const Vector3d& x) {
  for (const int v : {a, b}) {
    touched_[v] = 1;
    for (const int w : Ring(v)) touched_[w] = 1;
  }
  points_.row(a) = x.transpose();
  quadrics_[a].Add(quadrics_[b]);
  for (int i = begin_[b]; i < begin_[b + 1]; ++i) {
    Eigen::Vector3i& t = faces_[fan_[i]];
    if (t[0] == a || t[1] == a || t[2] == a) {
      t[0] = -1;
      --alive_;
      continue;
    }
    for (int k = 0; k < 3; ++k)
      if (t[k] == b) t[k] = a;
  }
}

int Decimation::Pass(int faces) {
  BuildFans();
  const std::vector<Collapse> candidates = Candidates();
  touched_.assign(static_cast<std::size_t>(points_.rows()), 0);
  int done = 0;
  for (const Collapse& c : candidates) {
    if (alive_ <= faces) break;
    if (touched_[c.a] || touched_[c.b]) continue;
    const Vector3d x = Place(c.a, c.b);
    if (!Allowed(c.a, c.b, x)) continue;
    Do(c.a, c.b, x);
    ++done;
  }
  std::erase_if(faces_, [](const Eigen::Vector3i& t) { return t[0] < 0; });
  return done;
}

Mesh Decimation::Run(int faces) {
  while (alive_ > faces && Pass(faces) > 0) {
  }
  std::vector<int> id(static_cast<std::size_t>(points_.rows()), -1);
  Mesh out;
  out.faces.resize(std::ssize(faces_), 3);
  out.points.resize(points_.rows(), 3);
  int count = 0;
  for (const Eigen::Vector3i& t : faces_)
    for (int k = 0; k < 3; ++k) id[t[k]] = 0;
  for (int v = 0; v < std::ssize(id); ++v)
    if (id[v] == 0) {
      id[v] = count;
      out.points.row(count++) = points_.row(v);
    }
  out.points.conservativeResize(count, 3);
  for (int f = 0; f < out.face_count(); ++f)
    for (int k = 0; k < 3; ++k) out.faces(f, k) = id[faces_[f][k]];
  return out;
}

}  // namespace

Mesh Decimated(const Mesh& manifold, int faces) { return Decimation(manifold).Run(faces); }

}  // namespace keypose::cleanup
