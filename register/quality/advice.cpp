// Where one more landmark would help. Unlike registration_quality.cpp, it works on patches of the
// source, not on samples.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "deform/levels/step_queue.h"
#include "register/quality/closest_points.h"
#include "register/quality/registration_quality.h"

namespace keypose::registration {

namespace {

using Eigen::VectorXd;
constexpr double kUnreached = std::numeric_limits<double>::infinity();
constexpr int kPatches = 120;
constexpr int kTargetSamples = 2500;
constexpr int kMostFaces = 200000;  // about how many source faces are measured

// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct AdviceTuning {
  // of the source's diagonal: least distance between two places and from a landmark
  KEYPOSE_TUNED(double, kApart, 0.08);
  // of the diagonal: roughly how far a landmark holds the surface
  KEYPOSE_TUNED(double, kReach, 0.12);
  // need of a landmark: 1 for each kMisfitUnit, log kStretchUnit and 1 / kFlipped
  KEYPOSE_TUNED(double, kMisfitUnit, 0.01);  // of the target's diagonal
  KEYPOSE_TUNED(double, kStretchUnit, 1.5);  // factor by which edges change
  KEYPOSE_TUNED(double, kFlipped, 2);        // per share of area
  KEYPOSE_TUNED(double, kLeastNeed, 0.15);   // below this nothing is wrong
  // score of the middle of the body; the end of a limb has 1 more
  KEYPOSE_TUNED(double, kMiddle, 0.5);
  // of the area: a smaller component needs no landmark of its own
  KEYPOSE_TUNED(double, kSmallPart, 0.05);
};

/// The source's edges: for each vertex its neighbours, and the edge lengths.
struct Graph {
  std::vector<int> begin, neighbor;
  std::vector<double> length;
  double steps_per_length = 0;  // of the search queue, see GeodesicGraph

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
      steps_per_length += d;
    }
    steps_per_length = 4 * static_cast<double>(edges.size()) / steps_per_length;
    if (!std::isfinite(steps_per_length)) steps_per_length = 0;
  }

  /// Lowers `distance` to the distance along edges from new seeds. Sets `owner` to `label` where
  /// `distance` changed.
  void Spread(const std::vector<std::pair<int, double>>& seeds, int label, VectorXd& distance,
              std::vector<int>& owner) const {
    StepQueue queue(steps_per_length);
    const auto reach = [&](int v, double d) {
      if (!(d < distance[v])) return;
      distance[v] = d;
      owner[v] = label;
      queue.Put(v, d);
    };
    for (const auto& [v, d] : seeds) reach(v, d);
    queue.Run([&](int v, double here) {
      if (here > distance[v]) return;
      for (int k = begin[v]; k < begin[v + 1]; ++k) reach(neighbor[k], here + length[k]);
    });
  }
};

/// The source divided into patches of about equal size.
struct SignalPatches {
  std::vector<int> of_vertex;  // -1: of no patch
  std::vector<int> seeds;
  VectorXd out;  // for each patch: mean distance to the others, over the largest such mean; near 1
                 // at the ends of limbs

  SignalPatches(const Mesh& mesh, const Graph& graph, const std::vector<char>& wanted)
      : of_vertex(mesh.vertex_count(), -1) {
    VectorXd distance = VectorXd::Constant(mesh.vertex_count(), kUnreached);
    for (int v = 0; v < mesh.vertex_count(); ++v)
      if (!wanted[v]) distance[v] = 0;
    for (int n = 0; n < kPatches; ++n) {
      int farthest = 0;
      if (!(distance.maxCoeff(&farthest) > 0)) break;
      graph.Spread({{farthest, 0.0}}, n, distance, of_vertex);
      seeds.push_back(farthest);
    }
    out = VectorXd::Zero(std::ssize(seeds));
    std::vector<int> unused(mesh.vertex_count());
    // Every tenth patch is enough to distinguish the ends from the middle.
    for (std::size_t n = 0; n < seeds.size(); n += 10) {
      VectorXd d = VectorXd::Constant(mesh.vertex_count(), kUnreached);
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
  int count = 0;
  for (int seed = 0; seed < mesh.vertex_count(); ++seed) {
    if (component[seed] >= 0) continue;
    std::vector<int> reached = {seed};
    component[seed] = count;
    for (std::size_t k = 0; k < reached.size(); ++k)
      for (int s = graph.begin[reached[k]]; s < graph.begin[reached[k] + 1]; ++s)
        if (const int w = graph.neighbor[s]; component[w] < 0) {
          component[w] = count;
          reached.push_back(w);
        }
    ++count;
  }
  const VectorXd areas = FaceAreas(mesh.points, mesh.faces);
  VectorXd share = VectorXd::Zero(count);
  const double total = areas.sum();
  for (Eigen::Index f = 0; f < areas.size(); ++f)
    share[component[mesh.faces(f, 0)]] += areas[f] / total;
  std::vector<char> large(mesh.vertex_count());
  for (int v = 0; v < mesh.vertex_count(); ++v)
    large[v] = share[component[v]] >= AdviceTuning::kSmallPart;
  return large;
}

/// Means over the patches, weighted by area.
struct Signals {
  VectorXd misfit, stretch,
      flipped;  // over the diagonal; natural logarithm of the larger change; share of area
};

/// The same signals for each measured face.
struct FaceSignals {
  std::vector<int> faces;
  VectorXd misfit, stretch, flipped, area;
};

double LargerChange(const Mesh& source, const PointsX3& registered, int f, double scale) {
  double largest = 0;
  for (int k = 0; k < 3; ++k) {
    const int a = source.faces(f, k), b = source.faces(f, (k + 1) % 3);
    const double before = (source.points.row(a) - source.points.row(b)).norm() * scale,
                 after = (registered.row(a) - registered.row(b)).norm();
    if (before > 0)
      largest = std::max(largest, std::abs(std::log(std::clamp(after / before, 0.1, 10.0))));
  }
  return largest;
}

/// For each registered face, the largest distance of the target samples that are nearest to it. If
/// a limb did not follow, this is large at its end.
VectorXd MissedTarget(int face_count, const Mesh& target, const ResultSurfaces& surfaces) {
  VectorXd missed = VectorXd::Zero(face_count);
  if (!(SurfaceArea(target.points, target.faces) > 0)) return missed;
  for (const RayScene::Foot& foot :
       ClosestPoints(surfaces.registered,
                     SampleSurface(target.points, target.faces, kTargetSamples, 3).points))
    if (foot.face >= 0)
      missed[foot.face] = std::max(missed[foot.face], std::sqrt(foot.squared_distance));
  return missed;
}

FaceSignals MeasureFaces(const Mesh& source, const PointsX3& registered, const Mesh& target,
                         const ResultSurfaces& surfaces) {
  const double diagonal =
      std::max(BoundingDiagonal(target.points), std::numeric_limits<double>::min());
  const double ratio =
      SurfaceArea(registered, source.faces) / SurfaceArea(source.points, source.faces);
  const double scale = std::isfinite(ratio) && ratio > 0 ? std::sqrt(ratio) : 1;
  const VectorXd missed = MissedTarget(source.face_count(), target, surfaces);
  FaceSignals s;
  const int stride = 1 + (source.face_count() - 1) / kMostFaces;
  for (int f = 0; f < source.face_count(); ++f)
    if (f % stride == 0 || missed[f] > 0) s.faces.push_back(f);
  const auto count = std::ssize(s.faces);
  const FacesX3 faces = source.faces(s.faces, Eigen::all);
  PointsX3 centres(count, 3);
  for (Eigen::Index i = 0; i < count; ++i)
    centres.row(i) =
        (registered.row(faces(i, 0)) + registered.row(faces(i, 1)) + registered.row(faces(i, 2))) /
        3;
  const std::vector<RayScene::Foot> feet = ClosestPoints(surfaces.target, centres);
  const PointsX3 ours = FaceNormals(registered, faces),
                 theirs = FaceNormals(target.points, target.faces);
  s.area = FaceAreas(source.points, faces);
  s.misfit = s.stretch = s.flipped = VectorXd(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const RayScene::Foot& foot = feet[i];
    // Coordinates whose squares overflow single precision have no closest point.
    s.misfit[i] = std::max(foot.face < 0 ? 0 : std::sqrt(foot.squared_distance) / diagonal,
                           missed[s.faces[i]] / diagonal);
    s.flipped[i] = foot.face >= 0 && ours.row(i).dot(theirs.row(foot.face)) < 0;
    s.stretch[i] = LargerChange(source, registered, s.faces[i], scale);
  }
  return s;
}

Signals OverPatches(const Mesh& source, const FaceSignals& faces, const SignalPatches& patches) {
  const auto count = std::ssize(patches.seeds);
  Signals s{VectorXd::Zero(count), VectorXd::Zero(count), VectorXd::Zero(count)};
  VectorXd area = VectorXd::Constant(count, std::numeric_limits<double>::min());
  for (Eigen::Index f = 0; f < faces.area.size(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int n = patches.of_vertex[source.faces(faces.faces[f], k)];
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
    std::snprintf(text, sizeof(text), " %.0f %% of the diagonal from the nearest landmark",
                  100 * a.landmark_distance);
    reason += text;
  } else {
    reason += " without a landmark";
  }
  std::snprintf(
      text, sizeof(text),
      ": the surfaces are %.2f %% of the diagonal apart there, faces change by a factor of %.2f",
      100 * a.misfit, a.stretch);
  reason += text;
  std::snprintf(text, sizeof(text), ", and %.0f %% of them face the wrong way", 100 * flipped);
  return flipped > 0.02 ? reason + text : reason;
}

/// Distances along the surface from the landmarks and from the places advised so far.
struct Held {
  VectorXd distance;
  std::vector<int> unused;

  Held(const Graph& graph, const PointsX3& points, const std::vector<LandmarkGoal>& landmarks)
      : distance(VectorXd::Constant(points.rows(), kUnreached)),
        unused(static_cast<std::size_t>(points.rows())) {
    for (const LandmarkGoal& goal : landmarks) {
      std::vector<std::pair<int, double>> corners;
      const Eigen::Vector3d place = PositionOf(goal.source, points);
      for (int k = 0; k < 3; ++k)
        if (goal.source.weights[k] > 0)
          corners.emplace_back(goal.source.vertices[k],
                               (points.row(goal.source.vertices[k]).transpose() - place).norm());
      graph.Spread(corners, 0, distance, unused);
    }
  }
};

/// The patch where a landmark is needed most, -1 where none is.
/// @param best  receives the vertex, the score and the distance to what is held
Eigen::Index NeediestPatch(const SignalPatches& patches, const Signals& signals,
                           const VectorXd& held, double diagonal, LandmarkAdvice& best) {
  Eigen::Index best_patch = -1;
  for (std::size_t n = 0; n < patches.seeds.size(); ++n) {
    const auto i = static_cast<Eigen::Index>(n);
    const double need = signals.misfit[i] / AdviceTuning::kMisfitUnit +
                        signals.stretch[i] / std::log(AdviceTuning::kStretchUnit) +
                        AdviceTuning::kFlipped * signals.flipped[i];
    const double away = held[patches.seeds[n]] / diagonal;
    if (need < AdviceTuning::kLeastNeed || away < AdviceTuning::kApart) continue;
    // The effect of a landmark falls with distance. The end of a limb is held from one side only,
    // so it gets a higher score.
    const double score = need * (std::isfinite(away) ? away / (away + AdviceTuning::kReach) : 1) *
                         (AdviceTuning::kMiddle + patches.out[i] * patches.out[i]);
    if (score <= best.score) continue;
    best.vertex = patches.seeds[n];
    best.score = score;
    best.landmark_distance = away;
    best_patch = i;
  }
  return best_patch;
}

}  // namespace

std::vector<LandmarkAdvice> AdviseLandmarks(const Mesh& source, const PointsX3& registered,
                                            const Mesh& target,
                                            const std::vector<LandmarkGoal>& landmarks, int count) {
  return AdviseLandmarks(source, registered, target, landmarks,
                         MakeResultSurfaces(source, registered, target), count);
}

std::vector<LandmarkAdvice> AdviseLandmarks(const Mesh& source, const PointsX3& registered,
                                            const Mesh& target,
                                            const std::vector<LandmarkGoal>& landmarks,
                                            const ResultSurfaces& surfaces, int count) {
  RequireUsable(source, "register: source");
  const Graph graph(source);
  const SignalPatches patches(source, graph, LargeComponents(source, graph));
  const Signals signals =
      OverPatches(source, MeasureFaces(source, registered, target, surfaces), patches);
  const double diagonal =
      std::max(BoundingDiagonal(source.points), std::numeric_limits<double>::min());
  Held held(graph, source.points, landmarks);
  std::vector<LandmarkAdvice> advice;
  while (SizeOf(advice) < count) {
    LandmarkAdvice best;
    const Eigen::Index best_patch = NeediestPatch(patches, signals, held.distance, diagonal, best);
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
