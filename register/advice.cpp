// Where one more landmark would help. Kept apart from the measures: it works on patches of the source, not on samples.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <queue>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/parallel.h"
#include "core/ray_scene.h"
#include "register/quality.h"

namespace keypose::registration {

namespace {

using Eigen::VectorXd;
constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr int kPatches = 120;
constexpr int kTargetSamples = 2500;
constexpr double kApart = 0.08;       // of the source's diagonal: the least distance between two places, and from a landmark
constexpr double kReach = 0.12;       // of the diagonal: how far a landmark holds the surface around it, roughly
constexpr double kMisfitUnit = 0.01;  // of the target's diagonal: this misfit weighs as much as a stretch by 1.5
constexpr double kLeastNeed = 0.15;   // below this nothing is wrong
constexpr double kSmallPart = 0.05;   // a component with less of the area needs no landmark of its own

/// The source's edges as lists of neighbours with lengths.
struct Graph {
  std::vector<int> begin, neighbor;
  std::vector<double> length;

  explicit Graph(const Mesh& mesh) : begin(mesh.vertex_count() + 1, 0) {
    const auto edges = UndirectedEdges(mesh.faces);
    for (const auto& [i, j] : edges) {
      ++begin[i + 1];
      ++begin[j + 1];
    }
    for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
    neighbor.resize(begin.back());
    length.resize(begin.back());
    std::vector<int> next(begin.begin(), begin.end() - 1);
    for (const auto& [i, j] : edges) {
      const double d = (mesh.points.row(i) - mesh.points.row(j)).norm();
      neighbor[next[i]] = j;
      length[next[i]++] = d;
      neighbor[next[j]] = i;
      length[next[j]++] = d;
    }
  }

  /// Lowers `distance` to the distance along edges from new seeds, and sets `owner` to `label` where it does.
  void Spread(const std::vector<std::pair<int, double>>& seeds, int label, VectorXd& distance, std::vector<int>& owner) const {
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    const auto reach = [&](int v, double d) {
      if (!(d < distance[v])) return;
      distance[v] = d;
      owner[v] = label;
      queue.emplace(d, v);
    };
    for (const auto& [v, d] : seeds) reach(v, d);
    while (!queue.empty()) {
      const auto [d, v] = queue.top();
      queue.pop();
      if (d > distance[v]) continue;
      for (int k = begin[v]; k < begin[v + 1]; ++k) reach(neighbor[k], d + length[k]);
    }
  }
};

/// The source cut into patches of about equal size, and how far along the surface each vertex is from the landmarks.
struct Patches {
  std::vector<int> of_vertex;  // -1: of no patch
  std::vector<int> seeds;
  VectorXd out;  // for each patch: mean distance to all others over the largest such mean; near 1 at the ends of limbs

  Patches(const Mesh& mesh, const Graph& graph, const std::vector<char>& wanted) : of_vertex(mesh.vertex_count(), -1) {
    VectorXd distance = VectorXd::Constant(mesh.vertex_count(), kFar);
    for (int v = 0; v < mesh.vertex_count(); ++v)
      if (!wanted[v]) distance[v] = 0;
    for (int n = 0; n < kPatches; ++n) {
      int farthest = 0;
      if (!(distance.maxCoeff(&farthest) > 0)) break;
      graph.Spread({{farthest, 0.0}}, n, distance, of_vertex);
      seeds.push_back(farthest);
    }
    out = VectorXd::Zero(static_cast<Eigen::Index>(seeds.size()));
    std::vector<int> unused(mesh.vertex_count());
    // Every tenth patch is enough to tell the ends from the middle.
    for (std::size_t n = 0; n < seeds.size(); n += 10) {
      VectorXd d = VectorXd::Constant(mesh.vertex_count(), kFar);
      graph.Spread({{seeds[n], 0.0}}, 0, d, unused);
      for (std::size_t m = 0; m < seeds.size(); ++m)
        if (std::isfinite(d[seeds[m]])) out[static_cast<Eigen::Index>(m)] += d[seeds[m]];
    }
    if (out.size() > 0 && out.maxCoeff() > 0) out /= out.maxCoeff();
  }
};

/// Vertices of components that are large enough to matter.
std::vector<char> LargeComponents(const Mesh& mesh, const Graph& graph) {
  std::vector<int> component(mesh.vertex_count(), -1);
  VectorXd distance = VectorXd::Constant(mesh.vertex_count(), kFar);
  int count = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (component[v] < 0) graph.Spread({{v, 0.0}}, count++, distance, component);
  const VectorXd areas = FaceAreas(mesh.points, mesh.faces);
  VectorXd share = VectorXd::Zero(count);
  const double total = areas.sum();
  for (Eigen::Index f = 0; f < areas.size(); ++f) share[component[mesh.faces(f, 0)]] += areas[f] / total;
  std::vector<char> large(mesh.vertex_count());
  for (int v = 0; v < mesh.vertex_count(); ++v) large[v] = share[component[v]] >= kSmallPart;
  return large;
}

/// Means over the patches, weighed by area.
struct Signals {
  VectorXd misfit, stretch, flipped;  // over the diagonal; natural logarithm of the larger change; share of area
};

struct FaceSignals {
  VectorXd misfit, stretch, flipped, area;
};

double LargerChange(const Mesh& source, const PointsX3& registered, int f, double scale) {
  double largest = 0;
  for (int k = 0; k < 3; ++k) {
    const int a = source.faces(f, k), b = source.faces(f, (k + 1) % 3);
    const double before = (source.points.row(a) - source.points.row(b)).norm() * scale,
                 after = (registered.row(a) - registered.row(b)).norm();
    if (before > 0) largest = std::max(largest, std::abs(std::log(std::clamp(after / before, 0.1, 10.0))));
  }
  return largest;
}

FaceSignals MeasureFaces(const Mesh& source, const PointsX3& registered, const Mesh& target) {
  const double diagonal = std::max(BoundingDiagonal(target.points), std::numeric_limits<double>::min());
  const RayScene target_scene(target.points, target.faces), moved_scene(registered, source.faces);
  const PointsX3 ours = FaceNormals(registered, source.faces), theirs = FaceNormals(target.points, target.faces);
  const double ratio = SurfaceArea(registered, source.faces) / SurfaceArea(source.points, source.faces);
  const double scale = std::isfinite(ratio) && ratio > 0 ? std::sqrt(ratio) : 1;
  const int count = source.face_count();
  FaceSignals s{VectorXd(count), VectorXd(count), VectorXd(count), FaceAreas(source.points, source.faces)};
  ParallelBlocks(count, 256, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f) {
      const Eigen::Vector3d centre =
          (registered.row(source.faces(f, 0)) + registered.row(source.faces(f, 1)) + registered.row(source.faces(f, 2))) / 3;
      const RayScene::Foot foot = target_scene.ClosestPoint(centre);
      // Coordinates whose squares are no single-precision numbers have no closest point.
      s.misfit[f] = foot.face < 0 ? 0 : std::sqrt(foot.squared_distance) / diagonal;
      s.flipped[f] = foot.face >= 0 && ours.row(f).dot(theirs.row(foot.face)) < 0;
      s.stretch[f] = LargerChange(source, registered, static_cast<int>(f), scale);
    }
  });
  // What of the target nothing reaches counts where the nearest registered face is: a limb that stayed behind has all of it at its end.
  if (!(SurfaceArea(target.points, target.faces) > 0)) return s;
  const SurfaceSamples samples = SampleSurface(target.points, target.faces, kTargetSamples, 3);
  std::vector<RayScene::Foot> feet(samples.faces.size());
  ParallelBlocks(static_cast<std::int64_t>(feet.size()), 256, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) feet[i] = moved_scene.ClosestPoint(samples.points.row(i));
  });
  for (const RayScene::Foot& foot : feet)
    if (foot.face >= 0) s.misfit[foot.face] = std::max(s.misfit[foot.face], std::sqrt(foot.squared_distance) / diagonal);
  return s;
}

Signals OverPatches(const Mesh& source, const FaceSignals& faces, const Patches& patches) {
  const auto count = static_cast<Eigen::Index>(patches.seeds.size());
  Signals s{VectorXd::Zero(count), VectorXd::Zero(count), VectorXd::Zero(count)};
  VectorXd area = VectorXd::Constant(count, std::numeric_limits<double>::min());
  for (int f = 0; f < source.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int n = patches.of_vertex[source.faces(f, k)];
      if (n < 0) continue;
      area[n] += faces.area[f];
      s.misfit[n] += faces.area[f] * faces.misfit[f];
      s.stretch[n] += faces.area[f] * faces.stretch[f];
      s.flipped[n] += faces.area[f] * faces.flipped[f];
    }
  s.misfit.array() /= area.array();
  s.stretch.array() /= area.array();
  s.flipped.array() /= area.array();
  return s;
}

std::string Reason(const LandmarkAdvice& a, double flipped, double out) {
  char text[256];
  std::string reason = out > 0.85 ? "the end of a limb" : "a place";
  if (std::isfinite(a.landmark_distance)) {
    std::snprintf(text, sizeof(text), " %.0f %% of the diagonal from the nearest landmark", 100 * a.landmark_distance);
    reason += text;
  } else {
    reason += " with no landmark to hold it";
  }
  std::snprintf(text, sizeof(text), ": the surfaces are %.2f %% of the diagonal apart there, faces change by a factor of %.2f",
                100 * a.misfit, a.stretch);
  reason += text;
  std::snprintf(text, sizeof(text), ", and %.0f %% of them face the wrong way", 100 * flipped);
  return flipped > 0.02 ? reason + text : reason;
}

/// Distances along the surface from the landmarks, and from the places that were advised so far.
struct Held {
  VectorXd distance;
  std::vector<int> unused;
};

}  // namespace

std::vector<LandmarkAdvice> AdviseLandmarks(const Mesh& source, const PointsX3& registered, const Mesh& target,
                                            const std::vector<LandmarkGoal>& landmarks, int count) {
  RequireUsable(source, "register: source");
  RequireUsable(target, "register: target");
  if (registered.rows() != source.points.rows()) throw InputError("register: the registered mesh has not the source's vertices");
  if (!registered.allFinite()) throw InputError("register: registered: a vertex is not finite");
  const Graph graph(source);
  const Patches patches(source, graph, LargeComponents(source, graph));
  const Signals signals = OverPatches(source, MeasureFaces(source, registered, target), patches);
  const double diagonal = std::max(BoundingDiagonal(source.points), std::numeric_limits<double>::min());
  Held held{VectorXd::Constant(source.vertex_count(), kFar), std::vector<int>(source.vertex_count())};
  for (const LandmarkGoal& goal : landmarks) {
    std::vector<std::pair<int, double>> corners;
    const Eigen::Vector3d place = PositionOf(goal.source, source.points);
    for (int k = 0; k < 3; ++k)
      if (goal.source.weights[k] > 0)
        corners.emplace_back(goal.source.vertices[k], (source.points.row(goal.source.vertices[k]).transpose() - place).norm());
    graph.Spread(corners, 0, held.distance, held.unused);
  }
  std::vector<LandmarkAdvice> advice;
  while (static_cast<int>(advice.size()) < count) {
    LandmarkAdvice best;
    Eigen::Index best_patch = -1;
    for (std::size_t n = 0; n < patches.seeds.size(); ++n) {
      const auto i = static_cast<Eigen::Index>(n);
      const double need = signals.misfit[i] / kMisfitUnit + signals.stretch[i] / std::log(1.5) + 2 * signals.flipped[i];
      const double away = held.distance[patches.seeds[n]] / diagonal;
      if (need < kLeastNeed || away < kApart) continue;
      // A landmark's hold fades with distance; the end of a limb has nothing beyond it that could hold it.
      const double score = need * (std::isfinite(away) ? away / (away + kReach) : 1) * (0.5 + patches.out[i] * patches.out[i]);
      if (score <= best.score) continue;
      best.vertex = patches.seeds[n];
      best.score = score;
      best.landmark_distance = away;
      best_patch = i;
    }
    if (best_patch < 0) break;
    best.position = source.points.row(best.vertex);
    best.registered = registered.row(best.vertex);
    best.misfit = signals.misfit[best_patch];
    best.stretch = std::exp(signals.stretch[best_patch]);
    best.reason = Reason(best, signals.flipped[best_patch], patches.out[best_patch]);
    advice.push_back(best);
    graph.Spread({{best.vertex, 0.0}}, 0, held.distance, held.unused);
  }
  return advice;
}

}  // namespace keypose::registration
