#include "texture/charts/hidden_seams.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "core/numbers/max_flow.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::texture {
namespace {

using Eigen::Vector3d;

// Chosen on the meshes of docs/results/texture.md (armadillo, ogre, spot, skull, plush dog, limbed
// figure) by the seams' exposure; no record of the trials.
struct HiddenSeamTuning {
  // cost per length of an invisible seam, of that of a fully visible one
  KEYPOSE_TUNED(double, kLeastCost, 0.12);
  // mean edge lengths below the smoothed surface, where a seam has half the cost
  KEYPOSE_TUNED(double, kCreaseDepth, 0.15);
  KEYPOSE_TUNED(double, kSightPower, 1.5);   // exponent of the visible share in the cost
  KEYPOSE_TUNED(double, kFrontFactor, 1.5);  // factor of the cost where the front is in view
  KEYPOSE_TUNED(int, kSmoothing, 8);         // rounds of the smoothing that creases lie below
  // of the cost: for a smaller gain two charts are not flattened again
  KEYPOSE_TUNED(double, kLeastGain, 0.02);
};

constexpr int kDirections = 60;
// costs in a cut are integers, for an exact result
constexpr double kWeightScale = 1e4;

struct View {
  Vector3d direction;  // towards the viewer
  double weight;
};

std::vector<View> ViewsOf(const Viewers& viewers) {
  const Vector3d up = viewers.up.normalized(),
                 front = (viewers.front - viewers.front.dot(up) * up).normalized(),
                 side = up.cross(front);
  std::vector<View> views;
  for (int i = 0; i < kDirections; ++i) {  // a Fibonacci lattice
    const double z = 1 - (2 * i + 1.0) / kDirections, r = std::sqrt(1 - z * z),
                 angle = i * EIGEN_PI * (3 - std::sqrt(5.0));
    const double x = r * std::cos(angle);
    const double height = std::clamp((z + 0.7) / 0.7, 0.1, 1.0);  // seldom from below
    views.push_back({x * front + r * std::sin(angle) * side + z * up, height * (0.65 + 0.35 * x)});
  }
  return views;
}

PointsX3 VertexNormals(const Surface& s) {
  PointsX3 normals = PointsX3::Zero(s.points.rows(), 3);
  for (int f = 0; f < static_cast<int>(s.faces.rows()); ++f)
    for (int k = 0; k < 3; ++k) normals.row(s.faces(f, k)) += s.areas[f] * s.normals.row(f);
  for (Eigen::Index v = 0; v < normals.rows(); ++v)
    normals.row(v) /= std::max(normals.row(v).norm(), 1e-300);
  return normals;
}

// Moves each vertex to the mean of its neighbours; every edge occurs twice, once from each face.
PointsX3 Smoothed(const Surface& s, PointsX3 points, int rounds) {
  Eigen::VectorXd count = Eigen::VectorXd::Zero(points.rows());
  for (int f = 0; f < static_cast<int>(s.faces.rows()); ++f)
    for (int k = 0; k < 3; ++k) count[s.faces(f, k)] += 2;
  for (int round = 0; round < rounds; ++round) {
    PointsX3 sum = PointsX3::Zero(points.rows(), 3);
    for (int f = 0; f < static_cast<int>(s.faces.rows()); ++f)
      for (int k = 0; k < 3; ++k)
        sum.row(s.faces(f, k)) +=
            points.row(s.faces(f, (k + 1) % 3)) + points.row(s.faces(f, (k + 2) % 3));
    for (Eigen::Index v = 0; v < points.rows(); ++v)
      points.row(v) = 0.5 * points.row(v) + 0.5 * sum.row(v) / std::max(count[v], 1.0);
  }
  return points;
}

// Depth of each vertex below the smoothed surface, in mean edge lengths; negative on ridges.
Eigen::VectorXd CreaseDepth(const Surface& s, const PointsX3& normals) {
  const PointsX3 smooth = Smoothed(s, s.points, HiddenSeamTuning::kSmoothing);
  double length = 0;
  for (int f = 0; f < static_cast<int>(s.faces.rows()); ++f)
    for (int k = 0; k < 3; ++k)
      length += (s.points.row(s.faces(f, k)) - s.points.row(s.faces(f, (k + 1) % 3))).norm();
  length /= 3.0 * static_cast<double>(s.faces.rows());
  return (smooth - s.points).cwiseProduct(normals).rowwise().sum() / std::max(length, 1e-300);
}

// Rings of faces of `a` and `b` around their common border: 0 beside it; -1 beyond `band`.
std::unordered_map<int, int> Rings(const Surface& s, const std::vector<int>& label, int a, int b,
                                   int band) {
  std::unordered_map<int, int> ring;
  std::vector<int> queue;
  for (int f = 0; f < std::ssize(label); ++f) {
    if (label[f] != a && label[f] != b) continue;
    for (int k = 0; k < 3; ++k) {
      if (label[s.neighbors(f, k)] != a + b - label[f]) continue;
      ring[f] = 0;
      queue.push_back(f);
      break;
    }
  }
  for (std::size_t i = 0; i < queue.size(); ++i) {
    const int f = queue[i];
    if (ring[f] == band) continue;
    for (int k = 0; k < 3; ++k) {
      const int next = s.neighbors(f, k);
      if (label[next] != label[f] || !ring.emplace(next, ring[f] + 1).second) continue;
      queue.push_back(next);
    }
  }
  return ring;
}

// The faces that the cut moves to the other chart, unless the gain is too small.
std::vector<int> WorthChanging(const Surface& s, const PointsX3& costs,
                               const std::vector<int>& label, int a, const std::vector<int>& faces,
                               const std::unordered_map<int, int>& node, const MinCut& cut) {
  std::vector<int> changed;
  double before = 0, after = 0;
  for (const int f : faces) {
    const bool with_a = cut.WithSource(node.at(f));
    if (with_a != (label[f] == a)) changed.push_back(f);
    for (int k = 0; k < 3; ++k) {
      const auto other = node.find(s.neighbors(f, k));
      if (other == node.end()) continue;
      if (label[other->first] != label[f]) before += costs(f, k);
      if (cut.WithSource(other->second) != with_a) after += costs(f, k);
    }
  }
  if (after > (1 - HiddenSeamTuning::kLeastGain) * before) changed.clear();
  return changed;
}

}  // namespace

Exposure FindExposure(const Surface& s, const Viewers& viewers) {
  using Tuning = HiddenSeamTuning;
  const PointsX3 normals = VertexNormals(s);
  const Eigen::VectorXd depth = CreaseDepth(s, normals);
  const std::vector<View> views = ViewsOf(viewers);
  const RayScene scene(s.points, s.faces);
  const double diagonal = BoundingDiagonal(s.points), near = 1e-4 * diagonal, far = 2 * diagonal;
  const Vector3d front = viewers.front.normalized();
  // The normalisation: the sum for a normal that faces the front, about the largest possible.
  double most = 0;
  for (const View& view : views) most += view.weight * std::max(0.0, view.direction.dot(front));
  const Eigen::Index count = s.points.rows();
  Exposure out{Eigen::VectorXd::Zero(count), Eigen::VectorXd::Zero(count),
               std::vector<char>(count, 0)};
  ParallelFor(
      count,
      [&](std::int64_t v) {
        const Vector3d normal = normals.row(v),
                       origin = s.points.row(v).transpose() + near * normal;
        const auto free = [&](const Vector3d& d) { return !scene.Occluded(origin, d, near, far); };
        double seen = 0;
        for (const View& view : views) {
          const double cosine = normal.dot(view.direction);
          if (cosine > 0 && free(view.direction)) seen += view.weight * cosine;
        }
        out.seen[v] = std::min(1.0, seen / most);
        const double crease = std::max(0.0, depth[v]) / Tuning::kCreaseDepth;
        out.front[v] = normal.dot(front) > 0.5 && free(front);
        const double sight = std::pow(out.seen[v], Tuning::kSightPower) / (1 + crease);
        out.cost[v] = (Tuning::kLeastCost + (1 - Tuning::kLeastCost) * sight) *
                      (out.front[v] ? Tuning::kFrontFactor : 1);
      },
      64);
  return out;
}

PointsX3 SeamCosts(const Surface& s, const Eigen::VectorXd& cost) {
  PointsX3 out(s.faces.rows(), 3);
  for (int f = 0; f < static_cast<int>(s.faces.rows()); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int a = s.faces(f, k), b = s.faces(f, (k + 1) % 3);
      out(f, k) = (s.points.row(a) - s.points.row(b)).norm() * (cost[a] + cost[b]) / 2;
    }
  }
  return out;
}

std::vector<int> BetterBorder(const Surface& s, const PointsX3& costs,
                              const std::vector<int>& label, int a, int b, int band) {
  const std::unordered_map<int, int> ring = Rings(s, label, a, b, band);
  std::vector<int> faces;
  int deepest[2] = {-1, -1};
  for (const auto& [f, depth] : ring) {
    faces.push_back(f);
    deepest[label[f] == b] = std::max(deepest[label[f] == b], depth);
  }
  if (deepest[0] < 1 || deepest[1] < 1) return {};
  std::sort(faces.begin(), faces.end());
  std::unordered_map<int, int> node;
  double mean = 0;
  for (const int f : faces) {
    node.emplace(f, SizeOf(node));
    mean += costs.row(f).mean() / static_cast<double>(faces.size());
  }
  constexpr std::int64_t kNever = std::int64_t{1} << 50;
  MinCut cut(SizeOf(faces));
  for (const int f : faces) {
    const int side = label[f] == b;
    // The last ring stays with its chart, so that neither chart disappears.
    if (ring.at(f) == deepest[side])
      cut.AddTerminals(node[f], side ? 0 : kNever, side ? kNever : 0);
    for (int k = 0; k < 3; ++k) {
      const auto other = node.find(s.neighbors(f, k));
      if (other == node.end() || other->first < f) continue;
      const std::int64_t capacity =
          1 + std::llround(kWeightScale * costs(f, k) / std::max(mean, 1e-300));
      cut.AddEdge(node[f], other->second, capacity, capacity);
    }
  }
  cut.Solve();
  return WorthChanging(s, costs, label, a, faces, node, cut);
}

}  // namespace keypose::texture
