#include "register/intrinsic/suggest.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numbers/kd_tree.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/percent.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "register/intrinsic/dense_map.h"
#include "register/intrinsic/intrinsic_shape.h"
#include "register/intrinsic/map_candidates.h"

namespace keypose::registration {

namespace {

// Chosen on the seven registration pairs (docs/results/landmarks.md); sensitivity:
// docs/results/sensitivity.md.
struct SuggestTuning {
  // over the square root of the area: largest distance of a matched tip from its refined image
  KEYPOSE_TUNED(double, kTipAgrees, 0.06);
  KEYPOSE_TUNED(double, kLikeness, 1);  // weight of descriptors relative to eigenfunctions
  // over the square root of the area: mean distance of images above which maps are different
  KEYPOSE_TUNED(double, kDifferent, 0.12);
  KEYPOSE_TUNED(double, kTurnedOver, 0.2);  // score of a map that turns all of the surface over
  // score over that of the best candidate: worse ones are not refined
  KEYPOSE_TUNED(double, kHopelessScore, 1.25);
};

constexpr int kMostTips = 9;
constexpr std::size_t kRefined = 3;
constexpr int kFirstSize = 32;
const std::vector<int> kFinalSizes = {14, 20, 26, 32, 40, 50, 60, 80, 100, 120};

/// The state of a search: both poses and what was found so far.
struct SuggestionSearch {
  const Mesh& source_mesh;
  const Mesh& target_mesh;
  IntrinsicShape source, target;
  std::vector<int> known_source, known_target;  ///< proxy vertices
  std::vector<MapCandidate> candidates;
  MapCandidate best;
  PointMaps maps;              ///< between all proxy vertices
  Eigen::VectorXd confidence;  ///< of proxy vertices of the source
};

int HeaviestCorner(const SurfacePoint& point) {
  Eigen::Index k = 0;
  point.weights.maxCoeff(&k);
  return point.vertices[k];
}

bool HasColors(const Mesh& mesh) { return mesh.colors.rows() == mesh.points.rows(); }

/// Converts known pairs to proxy vertices. Pairs with an end on another piece are left out.
void TakeKnown(const std::vector<LandmarkGoal>& known, SuggestionSearch& search) {
  if (known.empty()) return;
  const KdTree tree(search.target_mesh.points);
  for (const LandmarkGoal& goal : known) {
    const int vertex = HeaviestCorner(goal.source);
    if (vertex < 0 || vertex >= search.source_mesh.vertex_count())
      throw InputError("register: landmark '" + goal.name +
                       "' is not on the source; it was picked on another mesh: pick it again");
    const int source = search.source.proxy_of[vertex];
    const int target = search.target.proxy_of[tree.Nearest(goal.target).index];
    if (source < 0 || target < 0) continue;
    search.known_source.push_back(source);
    search.known_target.push_back(target);
  }
}

/// Mean distance between the images of two maps' samples.
double Apart(const SuggestionSearch& search, const MapCandidate& a, const MapCandidate& b) {
  double apart = 0;
  for (std::size_t s = 0; s < a.maps.forward.size(); ++s)
    apart +=
        search.target.sample_distances(a.maps.forward[s], search.target.samples[b.maps.forward[s]]);
  return apart / static_cast<double>(a.maps.forward.size());
}

/// The best candidates that are really different maps, not the same map found from other tips.
std::vector<MapCandidate> DifferentCandidates(const SuggestionSearch& search, std::size_t most) {
  std::vector<MapCandidate> different;
  for (const MapCandidate& candidate : search.candidates) {
    if (different.size() >= most) break;
    if (std::all_of(different.begin(), different.end(), [&](const MapCandidate& d) {
          return Apart(search, d, candidate) > SuggestTuning::kDifferent;
        }))
      different.push_back(candidate);
  }
  return different;
}

/// Extends a map of samples to all proxy vertices and refines it with more functions.
PointMaps RefinedOnProxies(const SuggestionSearch& search, const PointMaps& sample_maps) {
  const IntrinsicShape &a = search.source, &b = search.target;
  const JointEmbedding coarse = FitEmbedding(a.sampled, b.sampled, sample_maps, kFirstSize);
  const PointMaps maps =
      NearestRows(coarse.SourceRows(a.all.functions), coarse.TargetRows(b.all.functions));
  std::vector<int> sizes;
  const auto most = static_cast<int>(std::min(a.all.functions.cols(), b.all.functions.cols()));
  for (const int size : kFinalSizes)
    if (size <= most) sizes.push_back(size);
  if (sizes.empty()) sizes = {most};
  const MatchHints hints{a.descriptors.cast<float>(), b.descriptors.cast<float>(),
                         SuggestTuning::kLikeness};
  return RefineMaps(a.all, b.all, maps, sizes, hints);
}

/// Refines the best candidates and keeps the best result. The resolution of the candidates can be
/// too low to tell left from right on a slim body; the refined maps can.
void RefineBest(const MapSearch& candidates, SuggestionSearch& search, double& margin) {
  std::vector<MapCandidate> different = DifferentCandidates(search, kRefined);
  margin = 1;
  for (std::size_t k = 0; k < different.size(); ++k) {
    MapCandidate& candidate = different[k];
    if (k > 0 && candidate.score > SuggestTuning::kHopelessScore * different[0].score) break;
    const PointMaps maps = RefinedOnProxies(search, candidate.maps);
    PointMaps sampled;
    for (const int v : search.source.samples)
      sampled.forward.push_back(search.target.sample_of[maps.forward[v]]);
    for (const int v : search.target.samples)
      sampled.backward.push_back(search.source.sample_of[maps.backward[v]]);
    MapCandidate scored = candidates.Scored(candidate.source_tips, candidate.target_tips, sampled);
    // A mirror image can preserve distances, but it turns a large part of the surface inside out.
    scored.score += SuggestTuning::kTurnedOver *
                    (1 - OrientationShare(search.source, search.target, maps.forward));
    if (k == 0 || scored.score < search.best.score) {
      if (k > 0) margin = search.best.score / scored.score - 1;
      search.best = scored;
      search.maps = maps;
    } else {
      margin = std::min(margin, scored.score / search.best.score - 1);
    }
  }
  search.confidence = MapConfidence(search.source, search.target, search.maps);
}

class FaceOfVertex {
 public:
  explicit FaceOfVertex(const Mesh& mesh)
      : place_(static_cast<std::size_t>(mesh.vertex_count()), {-1, 0}) {
    for (Eigen::Index f = mesh.faces.rows() - 1; f >= 0; --f)
      for (int k = 0; k < 3; ++k) place_[mesh.faces(f, k)] = {static_cast<int>(f), k};
  }
  void Set(int vertex, int& face, Eigen::Vector3d& barycentric) const {
    face = place_[vertex].first;
    barycentric = Eigen::Vector3d::Unit(place_[vertex].second);
  }

 private:
  std::vector<std::pair<int, int>> place_;
};

/// A pair of proxy vertices to suggest.
struct ProxyPair {
  int source, target;
  double confidence;
  const char* origin;
};

std::vector<ProxyPair> TipPairs(const SuggestionSearch& search) {
  std::vector<ProxyPair> pairs;
  const MapCandidate& best = search.best;
  for (std::size_t k = 0; k < best.source_tips.size(); ++k) {
    const int s = best.source_tips[k], t = best.target_tips[k];
    if (s < std::ssize(search.known_source)) continue;
    const int vs = search.source.tips[s], vt = search.target.tips[t];
    // Where the assigned tip and the refined map disagree, one of them is wrong; do not suggest it.
    const double off = search.target.tip_distances(t, search.maps.forward[vs]);
    const double back = search.source.tip_distances(s, search.maps.backward[vt]);
    if (std::max(off, back) > SuggestTuning::kTipAgrees) continue;
    const double agreement = 1 - std::max(off, back) / SuggestTuning::kTipAgrees;
    pairs.push_back({vs, vt, std::max(search.confidence[vs], 0.5 + 0.5 * agreement), "tip"});
  }
  return pairs;
}

/// Chooses tips first, then confident vertices that are far from all others.
std::vector<ProxyPair> ChoosePairs(const SuggestionSearch& search, const SuggestOptions& options) {
  std::vector<ProxyPair> pairs = TipPairs(search);
  std::stable_sort(pairs.begin(), pairs.end(), [](const ProxyPair& a, const ProxyPair& b) {
    return a.confidence > b.confidence;
  });
  if (SizeOf(pairs) > options.count) pairs.resize(static_cast<std::size_t>(options.count));
  std::vector<int> taken = search.known_source;
  for (const ProxyPair& pair : pairs) taken.push_back(pair.source);
  Eigen::VectorXd distance =
      taken.empty() ? search.source.mean_distance : search.source.graph->From(taken);
  while (SizeOf(pairs) < options.count) {
    int next = -1;
    double most = 0.05;  // a pair closer to the others adds nothing
    for (int v = 0; v < search.source.proxy.vertex_count(); ++v) {
      if (search.confidence[v] < options.min_confidence) continue;
      const double worth = distance[v] * search.confidence[v];
      if (worth > most) {
        most = worth;
        next = v;
      }
    }
    if (next < 0) break;
    pairs.push_back({next, search.maps.forward[next], search.confidence[next], "intrinsic"});
    distance = distance.cwiseMin(search.source.graph->From({next}));
  }
  return pairs;
}

void FillDense(SuggestionSearch& search, Suggestion& suggestion) {
  const IntrinsicShape &a = search.source, &b = search.target;
  const JointEmbedding joint =
      FitEmbedding(a.all, b.all, search.maps,
                   static_cast<int>(std::min(a.all.functions.cols(), b.all.functions.cols())));
  const OnProxy mapped = PreciseMap(a, FootOnProxy(search.source_mesh, a), b, search.maps, joint);
  suggestion.dense = NearestVertices(search.target_mesh, b, mapped);
  suggestion.confidence = Eigen::VectorXd::Zero(search.source_mesh.vertex_count());
  for (std::size_t v = 0; v < suggestion.dense.size(); ++v)
    if (suggestion.dense[v] >= 0)
      suggestion.confidence[static_cast<Eigen::Index>(v)] = search.confidence[a.proxy_of[v]];
}

void FillPairs(const SuggestionSearch& search, const SuggestOptions& options,
               Suggestion& suggestion) {
  const FaceOfVertex on_source(search.source_mesh), on_target(search.target_mesh);
  for (const ProxyPair& pair : ChoosePairs(search, options)) {
    SuggestedPair suggested;
    const int source = search.source.fine[pair.source];
    int target = search.target.fine[pair.target];
    if (pair.origin != std::string("tip") && suggestion.dense[source] >= 0)
      target = suggestion.dense[source];
    on_source.Set(source, suggested.pick.source_face, suggested.pick.source_barycentric);
    on_target.Set(target, suggested.pick.target_face, suggested.pick.target_barycentric);
    suggested.pick.name = "suggested-" + std::to_string(suggestion.pairs.size() + 1);
    suggested.confidence = pair.confidence;
    suggested.origin = pair.origin;
    suggestion.pairs.push_back(std::move(suggested));
  }
}

}  // namespace

std::vector<std::string> SuggestOptions::Problems() const {
  std::vector<std::string> problems;
  if (count < 0 || count > 1000) problems.push_back("count must be from 0 to 1000");
  if (proxy_vertices < 100 || proxy_vertices > 20000)
    problems.push_back("proxy_vertices must be from 100 to 20000");
  if (samples < 50 || samples > proxy_vertices)
    problems.push_back("samples must be from 50 to proxy_vertices");
  if (functions < 20 || functions > 500) problems.push_back("functions must be from 20 to 500");
  if (candidates < 1 || candidates > 10000)
    problems.push_back("candidates must be from 1 to 10000");
  if (!(min_confidence >= 0 && min_confidence <= 1))
    problems.push_back("min_confidence must be from 0 to 1");
  return problems;
}

Suggestion SuggestLandmarks(const Mesh& source, const Mesh& target,
                            const std::vector<LandmarkGoal>& known, const SuggestOptions& options,
                            Progress* progress) {
  RequireUsable(source, "register: source");
  RequireUsable(target, "register: target");
  if (const auto problems = options.Problems(); !problems.empty())
    throw InputError("register: " + problems.front());
  SuggestionSearch search{source, target, {}, {}, {}, {}, {}, {}, {}, {}};
  IntrinsicOptions intrinsic;
  intrinsic.vertices = options.proxy_vertices;
  intrinsic.samples = options.samples;
  intrinsic.functions = options.functions;
  ReportProgress(progress, 0.0, "landmarks: the source's limbs");
  search.source = MakeIntrinsicShape(source, intrinsic);
  ReportProgress(progress, 0.3, "landmarks: the target's limbs");
  search.target = MakeIntrinsicShape(target, intrinsic);
  ReportProgress(progress, 0.6, "landmarks: candidate maps");
  if (HasColors(source) && HasColors(target)) {
    AddColors(source.colors, search.source);
    AddColors(target.colors, search.target);
  }
  TakeKnown(known, search);
  FindTips(search.known_source, kMostTips, search.source);
  FindTips(search.known_target, kMostTips, search.target);
  const MapSearch candidates(search.source, search.target);
  search.candidates = candidates.Run(SizeOf(search.known_source), options.candidates);
  ReportProgress(progress, 0.8, "landmarks: refining");
  Suggestion suggestion;
  RefineBest(candidates, search, suggestion.margin);
  suggestion.distortion = search.best.distortion;
  suggestion.orientation = OrientationShare(search.source, search.target, search.maps.forward);
  FillDense(search, suggestion);
  FillPairs(search, options, suggestion);
  suggestion.explanation = "limb ends: " + std::to_string(search.source.tips.size()) +
                           " on the source, " + std::to_string(search.target.tips.size()) +
                           " on the target, " + std::to_string(search.best.source_tips.size()) +
                           " matched; " + PercentHalfEven(suggestion.orientation) +
                           " of the surface keeps its orientation";
  return suggestion;
}

}  // namespace keypose::registration
