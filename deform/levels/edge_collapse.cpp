#include "deform/levels/edge_collapse.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose {

namespace {

// No record of the data; judged by the registration that the levels give on the seven registration
// pairs (docs/results/registration.md); sensitivity: docs/results/sensitivity.md.
struct EdgeCollapseTuning {
  KEYPOSE_TUNED(double, kFoldCosine, 0.2);  // least cosine of a face's turn in a collapse
  // of the squared edge length, so that flat regions are decimated evenly
  KEYPOSE_TUNED(double, kLengthWeight, 1e-3);
  // least ratio of twice the area to the square of the longest side
  KEYPOSE_TUNED(double, kNeedle, 0.05);
};

constexpr int kLargestValence = 16;
constexpr std::int64_t kDecimationGrain = 4096;
constexpr double kShare = 0.5;  // of the vertices: candidates for collapse in a round
constexpr int kPerRemoved = 6;  // candidates for each vertex that must still be removed
// of the vertices: the rounds end when one removes fewer
constexpr double kFewestRemoved = 0.0005;

using Face = std::array<int, 3>;

bool Has(const Face& face, int v) { return face[0] == v || face[1] == v || face[2] == v; }

double Cost(const DecimatedMesh& mesh, const Quadric& quadric, int v, int w) {
  const Eigen::Vector3d x = mesh.points.row(w);
  const double length2 = (mesh.points.row(v) - mesh.points.row(w)).squaredNorm();
  return quadric.At(x) + EdgeCollapseTuning::kLengthWeight * length2 * length2;
}

/// Which corner of a face one of its vertices is.
int CornerOf(const Face& face, int v) {
  if (face[0] == v) return 0;
  return face[1] == v ? 1 : 2;
}

/// Whether the faces `around` v neither fold over nor become too thin when v moves to w.
template <class FacesAround>
bool KeepsNormals(const DecimatedMesh& mesh, const FacesAround& around, int v, int w) {
  const Eigen::Vector3d from = mesh.points.row(v), to = mesh.points.row(w);
  for (int f : around) {
    const Face& c = mesh.faces[f];
    if (Has(c, w)) continue;
    const int k = CornerOf(c, v);
    const Eigen::Vector3d a = mesh.points.row(c[(k + 1) % 3]), b = mesh.points.row(c[(k + 2) % 3]);
    const Eigen::Vector3d before = (a - from).cross(b - from), after = (a - to).cross(b - to);
    if (!(before.dot(after) > EdgeCollapseTuning::kFoldCosine * before.norm() * after.norm()))
      return false;
    // Very thin faces would make the Laplacian of the coarse mesh useless.
    const double longest2 =
        std::max({(a - to).squaredNorm(), (b - to).squaredNorm(), (a - b).squaredNorm()});
    if (after.norm() < EdgeCollapseTuning::kNeedle * longest2) return false;
  }
  return true;
}

/// A set of vertices that can be cleared at no cost.
class Marks {
 public:
  explicit Marks(std::size_t size) : stamp_(size, 0) {}
  void Clear() { ++now_; }
  bool Add(int v) { return std::exchange(stamp_[v], now_) != now_; }  ///< whether it is new
  bool Has(int v) const { return stamp_[v] == now_; }

 private:
  std::vector<int> stamp_;
  int now_ = 1;
};

/// The vertices around v, each once. Afterwards `marks` holds them and v.
template <class FacesAround>
void Neighbours(const DecimatedMesh& mesh, const FacesAround& around, int v, Marks& marks,
                std::vector<int>& out) {
  out.clear();
  marks.Clear();
  marks.Add(v);
  for (int f : around)
    for (int w : mesh.faces[f])
      if (marks.Add(w)) out.push_back(w);
}

/// Whether the topology stays the same when v, with neighbours `ring`, collapses into w, whose
/// neighbours are marked.
template <class FacesAround>
bool KeepsTopology(const DecimatedMesh& mesh, const FacesAround& around_v,
                   const FacesAround& around_w, const std::vector<int>& ring, int w,
                   std::size_t ring_of_w, const Marks& marked) {
  if (around_v.size() + around_w.size() <= 6) return false;
  int shared_faces = 0, common = 0;
  for (int f : around_v) shared_faces += Has(mesh.faces[f], w);
  for (int x : ring) common += x != w && marked.Has(x);
  const int merged_valence = static_cast<int>(ring_of_w + ring.size()) - common;
  // A vertex on the boundary, which has one more neighbour than faces, may only collapse along the
  // boundary.
  const bool on_boundary = ring.size() != around_v.size();
  return shared_faces == common && shared_faces == (on_boundary ? 1 : 2) &&
         merged_valence <= kLargestValence;
}

void AddFaces(DecimatedMesh& mesh) {
  mesh.quadrics.resize(mesh.vertex.size());
  for (const Face& f : mesh.faces) {
    const Eigen::Vector3d a = mesh.points.row(f[0]), b = mesh.points.row(f[1]),
                          c = mesh.points.row(f[2]);
    Eigen::Vector3d n = (b - a).cross(c - a);
    const double doubled_area = n.norm();
    if (!(doubled_area > 0)) continue;
    n /= doubled_area;
    for (int v : f) mesh.quadrics[v].AddPlane(n, -n.dot(a), doubled_area);
  }
}

/// Removes deleted vertices and faces.
void Compact(DecimatedMesh& mesh, const std::vector<char>& alive,
             const std::vector<char>& face_alive) {
  std::vector<int> index(mesh.vertex.size(), -1);
  int kept = 0;
  for (std::size_t v = 0; v < alive.size(); ++v) {
    if (!alive[v]) continue;
    mesh.vertex[kept] = mesh.vertex[v];
    mesh.points.row(kept) = mesh.points.row(v).eval();
    mesh.quadrics[kept] = mesh.quadrics[v];
    index[v] = kept++;
  }
  mesh.vertex.resize(kept);
  mesh.points.conservativeResize(kept, 3);
  mesh.quadrics.resize(kept);
  std::size_t faces = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    if (face_alive[f])
      mesh.faces[faces++] = {index[mesh.faces[f][0]], index[mesh.faces[f][1]],
                             index[mesh.faces[f][2]]};
  mesh.faces.resize(faces);
}

}  // namespace

void Quadric::AddPlane(const Eigen::Vector3d& normal, double offset, double weight) {
  const double v[4] = {normal[0], normal[1], normal[2], offset};
  int k = 0;
  for (int a = 0; a < 4; ++a)
    for (int b = a; b < 4; ++b) q[k++] += weight * v[a] * v[b];
}

void Quadric::Add(const Quadric& other) {
  for (int k = 0; k < 10; ++k) q[k] += other.q[k];
}

double Quadric::At(const Eigen::Vector3d& x) const {
  return q[0] * x[0] * x[0] + 2 * q[1] * x[0] * x[1] + 2 * q[2] * x[0] * x[2] + 2 * q[3] * x[0] +
         q[4] * x[1] * x[1] + 2 * q[5] * x[1] * x[2] + 2 * q[6] * x[1] + q[7] * x[2] * x[2] +
         2 * q[8] * x[2] + q[9];
}

DecimatedMesh ToDecimatedMesh(const PointsX3& points, const FacesX3& faces) {
  DecimatedMesh mesh;
  mesh.vertex.resize(points.rows());
  std::iota(mesh.vertex.begin(), mesh.vertex.end(), 0);
  mesh.points = points;
  mesh.faces.reserve(faces.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const Face face = {faces(f, 0), faces(f, 1), faces(f, 2)};
    if (face[0] != face[1] && face[1] != face[2] && face[2] != face[0]) mesh.faces.push_back(face);
  }
  AddFaces(mesh);
  return mesh;
}

struct HalfEdgeDecimator::Impl {
  struct Entry {
    double cost;
    int vertex, version;
    bool operator>(const Entry& o) const {
      return cost != o.cost ? cost > o.cost : vertex > o.vertex;
    }
  };
  /// The cheapest collapse of a vertex: its target and cost. `to` is -1 when it must be computed
  /// again.
  struct Best {
    double cost = std::numeric_limits<double>::infinity();
    int to = -1, version = 0;
    bool queued = false;
  };

  Impl(DecimatedMesh m, std::vector<int>& p);
  bool Allowed(int v, int w);
  void FindBest(int v);
  void Push(int v);
  void CollapseBest(int v);
  void Collapse(int v, int w);
  void Update(int x, int gone, int into);

  DecimatedMesh mesh;
  std::vector<int>& parent;
  std::vector<char> face_alive, alive;
  std::vector<std::vector<int>> faces_of;
  std::vector<Best> best;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  Marks marks, ring_marks;
  std::vector<int> ring, other_ring;
  std::vector<std::pair<double, int>> candidates;
  int left = 0;
};

HalfEdgeDecimator::Impl::Impl(DecimatedMesh m, std::vector<int>& p)
    : mesh(std::move(m)), parent(p), marks(mesh.vertex.size()), ring_marks(mesh.vertex.size()) {
  const std::size_t n = mesh.vertex.size();
  face_alive.assign(mesh.faces.size(), 1);
  alive.assign(n, 1);
  faces_of.resize(n);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (int v : mesh.faces[f]) faces_of[v].push_back(static_cast<int>(f));
  best.resize(n);
  left = static_cast<int>(n);
  for (std::size_t v = 0; v < n; ++v) {
    FindBest(static_cast<int>(v));
    Push(static_cast<int>(v));
  }
}

bool HalfEdgeDecimator::Impl::Allowed(int v, int w) {
  Neighbours(mesh, faces_of[w], w, marks, other_ring);
  return KeepsTopology(mesh, faces_of[v], faces_of[w], ring, w, other_ring.size(), marks) &&
         KeepsNormals(mesh, faces_of[v], v, w);
}

void HalfEdgeDecimator::Impl::FindBest(int v) {
  Neighbours(mesh, faces_of[v], v, marks, other_ring);
  best[v].cost = std::numeric_limits<double>::infinity();
  best[v].to = -1;
  for (int w : other_ring)
    if (const double cost = Cost(mesh, mesh.quadrics[v], v, w); cost < best[v].cost) {
      best[v].cost = cost;
      best[v].to = w;
    }
}

void HalfEdgeDecimator::Impl::Push(int v) {
  ++best[v].version;
  best[v].queued = std::isfinite(best[v].cost);
  if (best[v].queued) open.push({best[v].cost, v, best[v].version});
}

void HalfEdgeDecimator::Impl::CollapseBest(int v) {
  Neighbours(mesh, faces_of[v], v, ring_marks, ring);
  candidates.clear();
  for (int w : ring) candidates.emplace_back(Cost(mesh, mesh.quadrics[v], v, w), w);
  std::sort(candidates.begin(), candidates.end());
  for (const auto& [cost, w] : candidates)
    if (Allowed(v, w)) return Collapse(v, w);
}

void HalfEdgeDecimator::Impl::Collapse(int v, int w) {
  for (int f : faces_of[v]) {
    Face& c = mesh.faces[f];
    if (Has(c, w)) {
      face_alive[f] = 0;
      for (int x : c)
        if (x != v) faces_of[x].erase(std::find(faces_of[x].begin(), faces_of[x].end(), f));
    } else {
      std::replace(c.begin(), c.end(), v, w);
      faces_of[w].push_back(f);
    }
  }
  faces_of[v].clear();
  alive[v] = 0;
  parent[mesh.vertex[v]] = mesh.vertex[w];
  mesh.quadrics[w].Add(mesh.quadrics[v]);
  --left;
  FindBest(w);
  Push(w);
  for (int x : ring)
    best[x].to = x == w || marks.Has(x)
                     ? best[x].to
                     : -1;  // at a corner of the boundary a neighbour may lose its last face
  const std::vector<int> touched = other_ring;
  for (int x : touched) Update(x, v, w);
}

/// Updates neighbour x after `gone` collapsed into `into`: its ring loses `gone` and gains `into`,
/// unless it had it before.
void HalfEdgeDecimator::Impl::Update(int x, int gone, int into) {
  Best& b = best[x];
  const double before = b.cost;
  if (b.to < 0 || b.to == gone)
    FindBest(x);
  else if (ring_marks.Has(x))
    if (const double cost = Cost(mesh, mesh.quadrics[x], x, into); cost < b.cost) {
      b.cost = cost;
      b.to = into;
    }
  if (!b.queued || b.cost != before) Push(x);
}

HalfEdgeDecimator::HalfEdgeDecimator(DecimatedMesh mesh, std::vector<int>& parent)
    : impl_(std::make_unique<Impl>(std::move(mesh), parent)) {}
HalfEdgeDecimator::~HalfEdgeDecimator() = default;

int HalfEdgeDecimator::DecimateTo(int count) {
  Impl& t = *impl_;
  while (t.left > count && !t.open.empty()) {
    const Impl::Entry entry = t.open.top();
    t.open.pop();
    if (!t.alive[entry.vertex] || t.best[entry.vertex].version != entry.version) continue;
    t.best[entry.vertex].queued = false;
    t.CollapseBest(entry.vertex);
  }
  return t.left;
}

DecimatedMesh HalfEdgeDecimator::Rest() const {
  DecimatedMesh rest = impl_->mesh;
  Compact(rest, impl_->alive, impl_->face_alive);
  return rest;
}

namespace {

/// One round of collapses whose neighbourhoods do not touch.
class Round {
 public:
  explicit Round(DecimatedMesh& mesh);
  /// @return the number of removed vertices, at most `most`
  int Run(double share, int most, std::vector<int>& parent);

 private:
  struct Around {
    const int *first, *last;
    const int* begin() const { return first; }
    const int* end() const { return last; }
    std::size_t size() const { return static_cast<std::size_t>(last - first); }
  };
  Around FacesOf(int v) const {
    return {faces_of_.data() + offset_[v], faces_of_.data() + offset_[v + 1]};
  }
  std::vector<std::pair<float, int>> Cheapest(std::size_t count) const;
  bool CollapseBest(int v, std::vector<int>& parent);
  void Collapse(int v, int w, std::vector<int>& parent);

  DecimatedMesh& mesh_;
  std::vector<int> offset_, faces_of_;
  std::vector<char> alive_, face_alive_, locked_;
  Marks marks_;
  std::vector<int> ring_, other_ring_;
  std::vector<std::pair<double, int>> candidates_;
};

Round::Round(DecimatedMesh& mesh) : mesh_(mesh), marks_(mesh.vertex.size()) {
  const std::size_t n = mesh.vertex.size();
  offset_.assign(n + 1, 0);
  for (const Face& f : mesh.faces)
    for (int v : f) ++offset_[v + 1];
  std::partial_sum(offset_.begin(), offset_.end(), offset_.begin());
  faces_of_.resize(3 * mesh.faces.size());
  std::vector<int> fill(offset_.begin(), offset_.end() - 1);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (int v : mesh.faces[f]) faces_of_[fill[v]++] = static_cast<int>(f);
  alive_.assign(n, 1);
  locked_.assign(n, 0);
  face_alive_.assign(mesh.faces.size(), 1);
}

/// The vertices with the cheapest collapses, the cheapest first.
std::vector<std::pair<float, int>> Round::Cheapest(std::size_t count) const {
  const std::size_t n = mesh_.vertex.size();
  std::vector<std::pair<float, int>> order(n);
  ParallelBlocks(static_cast<std::int64_t>(n), kDecimationGrain,
                 [&](std::int64_t begin, std::int64_t end) {
                   for (std::int64_t i = begin; i < end; ++i) {
                     const int v = static_cast<int>(i);
                     double least = std::numeric_limits<double>::infinity();
                     // The next corner in each face gives all neighbours of an inner vertex, and
                     // all but one of a boundary vertex.
                     for (int f : FacesOf(v)) {
                       const Face& c = mesh_.faces[f];
                       const int next = c[(CornerOf(c, v) + 1) % 3];
                       least = std::min(least, Cost(mesh_, mesh_.quadrics[v], v, next));
                     }
                     order[i] = {static_cast<float>(least), v};
                   }
                 });
  count = std::min(count, n);
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end());
  order.resize(count);
  std::sort(order.begin(), order.end());
  return order;
}

bool Round::CollapseBest(int v, std::vector<int>& parent) {
  const Around around = FacesOf(v);
  Neighbours(mesh_, around, v, marks_, ring_);
  candidates_.clear();
  for (int w : ring_)
    if (!locked_[w]) candidates_.emplace_back(Cost(mesh_, mesh_.quadrics[v], v, w), w);
  std::sort(candidates_.begin(), candidates_.end());
  for (const auto& [cost, w] : candidates_) {
    Neighbours(mesh_, FacesOf(w), w, marks_, other_ring_);
    if (!KeepsTopology(mesh_, around, FacesOf(w), ring_, w, other_ring_.size(), marks_)) continue;
    if (!KeepsNormals(mesh_, around, v, w)) continue;
    Collapse(v, w, parent);
    return true;
  }
  return false;
}

void Round::Collapse(int v, int w, std::vector<int>& parent) {
  for (int f : FacesOf(v)) {
    face_alive_[f] = !Has(mesh_.faces[f], w);
    std::replace(mesh_.faces[f].begin(), mesh_.faces[f].end(), v, w);
  }
  alive_[v] = 0;
  parent[mesh_.vertex[v]] = mesh_.vertex[w];
  mesh_.quadrics[w].Add(mesh_.quadrics[v]);
  // The face lists of the vertices around v are out of date, so these wait until the next round.
  for (int x : ring_) locked_[x] = 1;
}

int Round::Run(double share, int most, std::vector<int>& parent) {
  const auto n = static_cast<double>(mesh_.vertex.size());
  const auto count =
      static_cast<std::size_t>(std::min(share * n, static_cast<double>(kPerRemoved) * most));
  int gone = 0;
  for (const auto& [cost, v] : Cheapest(count)) {
    if (gone == most || !std::isfinite(cost)) break;
    if (!locked_[v]) gone += CollapseBest(v, parent);
  }
  Compact(mesh_, alive_, face_alive_);
  return gone;
}

}  // namespace

void DecimateInRounds(DecimatedMesh& mesh, int count, std::vector<int>& parent) {
  double share = kShare;
  while (SizeOf(mesh.vertex) > count) {
    const auto before = static_cast<double>(mesh.vertex.size());
    const int gone = Round(mesh).Run(share, SizeOf(mesh.vertex) - count, parent);
    if (gone >= kFewestRemoved * before || SizeOf(mesh.vertex) == count) continue;
    if (share == 1) return;
    share = 1;
  }
}

}  // namespace keypose
