#include "register/hierarchy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

#include "core/parallel.h"

namespace keypose::registration {

namespace {

constexpr double kFoldCosine = 0.2;     // a collapse may not turn a face further than this
constexpr double kLengthWeight = 1e-3;  // of squared edge length, so that flat regions thin out evenly
constexpr int kLargestValence = 14;

/// Symmetric quadric x^T A x + 2 b x + c.
struct Quadric {
  std::array<double, 10> q{};
  void AddPlane(const Eigen::Vector3d& n, double d, double weight) {
    const double v[4] = {n[0], n[1], n[2], d};
    int k = 0;
    for (int a = 0; a < 4; ++a)
      for (int b = a; b < 4; ++b) q[k++] += weight * v[a] * v[b];
  }
  void Add(const Quadric& other) {
    for (int k = 0; k < 10; ++k) q[k] += other.q[k];
  }
  double At(const Eigen::Vector3d& x) const {
    return q[0] * x[0] * x[0] + 2 * q[1] * x[0] * x[1] + 2 * q[2] * x[0] * x[2] + 2 * q[3] * x[0] + q[4] * x[1] * x[1] +
           2 * q[5] * x[1] * x[2] + 2 * q[6] * x[1] + q[7] * x[2] * x[2] + 2 * q[8] * x[2] + q[9];
  }
};

/// A mesh that loses vertices one by one.
class Thinner {
 public:
  Thinner(const PointsX3& points, const FacesX3& faces);
  /// Collapses until `count` vertices are left or no collapse is allowed; returns how many are left.
  int ThinTo(int count);
  CoarseLevel Snapshot(const std::vector<int>& finer_vertices) const;
  const std::vector<char>& alive() const { return alive_; }

 private:
  struct Entry {
    double cost;
    int vertex, version;
    bool operator>(const Entry& o) const { return cost != o.cost ? cost > o.cost : vertex > o.vertex; }
  };
  void BuildQuadrics();
  void Neighbours(int v, std::vector<int>& out) const;
  double Cost(int v, int w) const;
  bool Allowed(int v, int w);
  bool KeepsTopology(int v, int w);
  bool KeepsNormals(int v, int w) const;
  void Push(int v);
  bool CollapseBest(int v);
  void Collapse(int v, int w);

  const PointsX3& points_;
  std::vector<std::array<int, 3>> faces_;
  std::vector<char> face_alive_, alive_;
  std::vector<std::vector<int>> faces_of_;
  std::vector<Quadric> quadrics_;
  std::vector<int> version_, parent_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
  std::vector<int> ring_, other_ring_;
  int left_ = 0;
};

Thinner::Thinner(const PointsX3& points, const FacesX3& faces) : points_(points) {
  const std::size_t n = points.rows();
  faces_.resize(faces.rows());
  faces_of_.resize(n);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      faces_[f][k] = faces(f, k);
      faces_of_[faces(f, k)].push_back(static_cast<int>(f));
    }
  face_alive_.assign(faces_.size(), 1);
  alive_.assign(n, 1);
  version_.assign(n, 0);
  parent_.resize(n);
  for (std::size_t v = 0; v < n; ++v) parent_[v] = static_cast<int>(v);
  left_ = static_cast<int>(n);
  BuildQuadrics();
  for (std::size_t v = 0; v < n; ++v) Push(static_cast<int>(v));
}

void Thinner::BuildQuadrics() {
  quadrics_.resize(faces_of_.size());
  for (const std::array<int, 3>& f : faces_) {
    const Eigen::Vector3d a = points_.row(f[0]), b = points_.row(f[1]), c = points_.row(f[2]);
    Eigen::Vector3d n = (b - a).cross(c - a);
    const double doubled_area = n.norm();
    if (!(doubled_area > 0)) continue;
    n /= doubled_area;
    for (int v : f) quadrics_[v].AddPlane(n, -n.dot(a), doubled_area);
  }
}

void Thinner::Neighbours(int v, std::vector<int>& out) const {
  out.clear();
  for (int f : faces_of_[v])
    for (int w : faces_[f])
      if (w != v) out.push_back(w);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
}

double Thinner::Cost(int v, int w) const {
  const Eigen::Vector3d x = points_.row(w);
  const double length2 = (points_.row(v) - points_.row(w)).squaredNorm();
  return quadrics_[v].At(x) + kLengthWeight * length2 * length2;
}

bool Thinner::KeepsTopology(int v, int w) {
  Neighbours(w, other_ring_);
  int shared_faces = 0, common = 0, merged_valence = static_cast<int>(other_ring_.size());
  for (int f : faces_of_[v]) shared_faces += faces_[f][0] == w || faces_[f][1] == w || faces_[f][2] == w;
  for (int x : ring_) (std::binary_search(other_ring_.begin(), other_ring_.end(), x) ? common : merged_valence) += 1;
  // A vertex on the boundary may only slide along it: it has one more neighbour than faces.
  const bool on_boundary = ring_.size() != faces_of_[v].size();
  return shared_faces == common && (shared_faces == 2 || (on_boundary && shared_faces == 1)) && !(on_boundary && shared_faces == 2) &&
         merged_valence <= kLargestValence + 2 && faces_of_[v].size() + faces_of_[w].size() > 6;
}

bool Thinner::KeepsNormals(int v, int w) const {
  const Eigen::Vector3d from = points_.row(v), to = points_.row(w);
  for (int f : faces_of_[v]) {
    const std::array<int, 3>& c = faces_[f];
    if (c[0] == w || c[1] == w || c[2] == w) continue;
    const int k = c[0] == v ? 0 : c[1] == v ? 1 : 2;
    const Eigen::Vector3d a = points_.row(c[(k + 1) % 3]), b = points_.row(c[(k + 2) % 3]);
    const Eigen::Vector3d before = (a - from).cross(b - from), after = (a - to).cross(b - to);
    if (!(before.dot(after) > kFoldCosine * before.norm() * after.norm())) return false;
    // No needles: they make the Laplacian of the coarse mesh useless.
    const double longest2 = std::max({(a - to).squaredNorm(), (b - to).squaredNorm(), (a - b).squaredNorm()});
    if (after.norm() < 0.05 * longest2) return false;
  }
  return true;
}

bool Thinner::Allowed(int v, int w) { return KeepsTopology(v, w) && KeepsNormals(v, w); }

void Thinner::Push(int v) {
  Neighbours(v, ring_);
  double best = std::numeric_limits<double>::infinity();
  for (int w : ring_) best = std::min(best, Cost(v, w));
  if (std::isfinite(best)) open_.push({best, v, version_[v]});
}

bool Thinner::CollapseBest(int v) {
  Neighbours(v, ring_);
  std::vector<std::pair<double, int>> candidates;
  for (int w : ring_) candidates.emplace_back(Cost(v, w), w);
  std::sort(candidates.begin(), candidates.end());
  for (const auto& [cost, w] : candidates)
    if (Allowed(v, w)) {
      Collapse(v, w);
      return true;
    }
  return false;
}

void Thinner::Collapse(int v, int w) {
  for (int f : faces_of_[v]) {
    std::array<int, 3>& c = faces_[f];
    if (c[0] == w || c[1] == w || c[2] == w) {
      face_alive_[f] = 0;
      for (int x : c)
        if (x != v) faces_of_[x].erase(std::find(faces_of_[x].begin(), faces_of_[x].end(), f));
    } else {
      for (int& x : c)
        if (x == v) x = w;
      faces_of_[w].push_back(f);
    }
  }
  faces_of_[v].clear();
  alive_[v] = 0;
  parent_[v] = w;
  quadrics_[w].Add(quadrics_[v]);
  --left_;
  std::vector<int> touched;
  Neighbours(w, touched);
  touched.push_back(w);
  for (int x : touched) {
    ++version_[x];
    Push(x);
  }
}

int Thinner::ThinTo(int count) {
  while (left_ > count && !open_.empty()) {
    const Entry entry = open_.top();
    open_.pop();
    if (!alive_[entry.vertex] || version_[entry.vertex] != entry.version) continue;
    CollapseBest(entry.vertex);
  }
  return left_;
}

CoarseLevel Thinner::Snapshot(const std::vector<int>& finer_vertices) const {
  CoarseLevel level;
  std::vector<int> index(alive_.size(), -1);
  for (std::size_t v = 0; v < alive_.size(); ++v)
    if (alive_[v]) {
      index[v] = static_cast<int>(level.fine.size());
      level.fine.push_back(static_cast<int>(v));
    }
  level.points.resize(static_cast<Eigen::Index>(level.fine.size()), 3);
  for (std::size_t k = 0; k < level.fine.size(); ++k) level.points.row(static_cast<Eigen::Index>(k)) = points_.row(level.fine[k]);
  const auto kept = std::count(face_alive_.begin(), face_alive_.end(), 1);
  level.faces.resize(kept, 3);
  Eigen::Index row = 0;
  for (std::size_t f = 0; f < faces_.size(); ++f)
    if (face_alive_[f]) level.faces.row(row++) << index[faces_[f][0]], index[faces_[f][1]], index[faces_[f][2]];
  level.up.reserve(finer_vertices.size());
  for (int v : finer_vertices) {
    while (!alive_[v]) v = parent_[v];
    level.up.push_back(index[v]);
  }
  return level;
}

}  // namespace

std::vector<CoarseLevel> MakeHierarchy(const PointsX3& points, const FacesX3& faces, const std::vector<int>& counts) {
  std::vector<CoarseLevel> levels;
  Thinner thinner(points, faces);
  std::vector<int> finer(points.rows());
  for (std::size_t v = 0; v < finer.size(); ++v) finer[v] = static_cast<int>(v);
  for (int count : counts) {
    const std::size_t left = thinner.ThinTo(count);
    if (left > 0.8 * static_cast<double>(finer.size())) continue;
    levels.push_back(thinner.Snapshot(finer));
    finer = levels.back().fine;
  }
  return levels;
}

Prolongation MakeProlongation(const PointsX3& fine_points, const CoarseLevel& coarse) {
  const std::size_t n = coarse.points.rows();
  std::vector<std::vector<int>> ring(n);
  for (Eigen::Index f = 0; f < coarse.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      for (int j = 1; j < 3; ++j) ring[coarse.faces(f, k)].push_back(coarse.faces(f, (k + j) % 3));
  std::vector<double> spacing(n, 0);
  for (std::size_t v = 0; v < n; ++v) {
    std::sort(ring[v].begin(), ring[v].end());
    ring[v].erase(std::unique(ring[v].begin(), ring[v].end()), ring[v].end());
    for (int w : ring[v]) spacing[v] += (coarse.points.row(static_cast<Eigen::Index>(v)) - coarse.points.row(w)).norm();
    spacing[v] /= std::max<std::size_t>(1, ring[v].size());
  }
  Prolongation p;
  p.offset.push_back(0);
  std::vector<std::pair<double, int>> near;
  for (std::size_t i = 0; i < coarse.up.size(); ++i) {
    const int a = coarse.up[i];
    near.clear();
    const auto add = [&](int k) {
      near.emplace_back((fine_points.row(static_cast<Eigen::Index>(i)) - coarse.points.row(k)).squaredNorm(), k);
    };
    add(a);
    for (int k : ring[a]) add(k);
    std::sort(near.begin(), near.end());
    if (near.size() > Prolongation::kNodes) near.resize(Prolongation::kNodes);
    const double width2 = std::max(0.5 * spacing[a] * spacing[a], 1e-30);
    double sum = 0;
    for (const auto& [d2, k] : near) sum += std::exp(-(d2 - near[0].first) / width2);
    for (const auto& [d2, k] : near) {
      p.node.push_back(k);
      p.weight.push_back(static_cast<float>(std::exp(-(d2 - near[0].first) / width2) / sum));
    }
    p.offset.push_back(static_cast<int>(p.node.size()));
  }
  return p;
}

PointsX3 Prolong(const Prolongation& prolongation, const PointsX3& fine_rest, const PointsX3& coarse_rest, const PointsX3& coarse_moved,
                 const std::vector<Eigen::Matrix3d>& rotations) {
  PointsX3 moved(fine_rest.rows(), 3);
  ParallelBlocks(fine_rest.rows(), 2048, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double weights = 0;
      for (int s = prolongation.offset[i]; s < prolongation.offset[i + 1]; ++s) {
        const int k = prolongation.node[s];
        const double w = prolongation.weight[s];
        const Eigen::Vector3d arm = (fine_rest.row(i) - coarse_rest.row(k)).transpose();
        sum += w * (rotations[k] * arm + coarse_moved.row(k).transpose());
        weights += w;
      }
      moved.row(i) = (sum / weights).transpose();
    }
  });
  return moved;
}

}  // namespace keypose::registration
