#include "texture/bake/labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "core/numbers/max_flow.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::texture {
namespace {

using Eigen::Vector3f;
using Candidates = std::vector<std::vector<LabelCandidate>>;

/// Chosen on held-out photographs of the synthetic character, the plush dog and the skull
/// (docs/algorithms/bake.md); no record of single values.
struct LabelTuning {
  /// cost of a border of one mean edge length, in faces painted from a view of 1/e of the best
  /// quality
  KEYPOSE_TUNED(double, kSmoothness, 1);
  /// square root of linear light: where the two photographs differ by this, a border costs twice as
  /// much
  KEYPOSE_TUNED(double, kColorStep, 0.1);
};

struct Border {
  int a, b;     ///< the faces on both sides
  double cost;  ///< without the colours' part
};

/// Edges between two faces that both have candidates; an edge of three faces or more gives
/// consecutive pairs.
std::vector<Border> FindBorders(const Mesh& mesh, const Candidates& candidates) {
  std::vector<std::array<int, 3>> sides;  // low vertex, high vertex, face
  sides.reserve(3 * static_cast<std::size_t>(mesh.face_count()));
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.faces(f, k), b = mesh.faces(f, (k + 1) % 3);
      sides.push_back({std::min(a, b), std::max(a, b), f});
    }
  std::sort(sides.begin(), sides.end());
  double mean_length = 0;
  for (const auto& s : sides)
    mean_length +=
        (mesh.points.row(s[0]) - mesh.points.row(s[1])).norm() / static_cast<double>(sides.size());
  std::vector<Border> borders;
  for (std::size_t i = 1; i < sides.size(); ++i) {
    const auto &s = sides[i], &before = sides[i - 1];
    if (s[0] != before[0] || s[1] != before[1] || s[2] == before[2]) continue;
    if (candidates[s[2]].empty() || candidates[before[2]].empty()) continue;
    const double length = (mesh.points.row(s[0]) - mesh.points.row(s[1])).norm();
    borders.push_back({before[2], s[2], LabelTuning::kSmoothness * length * mean_length});
  }
  return borders;
}

/// The energy in integers, and labels with decreasing energy.
class Expansion {
 public:
  Expansion(const Mesh& mesh, const Candidates& candidates)
      : candidates_(candidates),
        borders_(FindBorders(mesh, candidates)),
        areas_(FaceAreas(mesh.points, mesh.faces)) {
    // The total data cost over the whole surface is far below 2^63, and the cost of one face of a
    // million is far above 1.
    unit_ = 1e12 / std::max(areas_.sum(), 1e-300);
    labels_.assign(candidates.size(), -1);
    best_.assign(candidates.size(), 0);
    for (std::size_t f = 0; f < candidates.size(); ++f)
      for (const LabelCandidate& c : candidates[f])
        if (c.quality > best_[f]) {
          best_[f] = c.quality;
          labels_[f] = c.view;
        }
    node_.assign(candidates.size(), -1);
    borders_of_.resize(candidates.size());
    for (std::size_t i = 0; i < borders_.size(); ++i) {
      borders_of_[borders_[i].a].push_back(static_cast<int>(i));
      borders_of_[borders_[i].b].push_back(static_cast<int>(i));
    }
    for (std::size_t f = 0; f < candidates.size(); ++f)
      for (const LabelCandidate& c : candidates[f]) {
        if (c.view >= std::ssize(faces_of_)) faces_of_.resize(c.view + 1);
        faces_of_[c.view].push_back(static_cast<int>(f));
      }
  }

  /// @return whether any face changed to `view`
  bool Expand(int view) {
    std::vector<int> faces;
    for (const int f : faces_of_[view]) {
      if (labels_[f] == view) continue;
      node_[f] = SizeOf(faces);
      faces.push_back(f);
    }
    if (faces.empty()) return false;
    MinCut cut(SizeOf(faces));
    // Faces on the source's side change to the view; undecided ones keep their label. The cut
    // separates the source from faces that keep their label, so that edge has the cost of keeping
    // it.
    for (std::size_t i = 0; i < faces.size(); ++i)
      cut.AddTerminals(static_cast<int>(i), Data(faces[i], labels_[faces[i]]),
                       Data(faces[i], view));
    for (const int f : faces)
      for (const int b : borders_of_[f]) {
        const Border& border = borders_[b];
        // A border between two such faces occurs from both sides.
        if (f == border.a || node_[border.a] < 0) AddBorder(border, view, cut);
      }
    cut.Solve();
    bool changed = false;
    for (std::size_t i = 0; i < faces.size(); ++i) {
      node_[faces[i]] = -1;
      if (!cut.WithSource(static_cast<int>(i))) continue;
      labels_[faces[i]] = view;
      changed = true;
    }
    return changed;
  }

  const std::vector<int>& labels() const { return labels_; }

 private:
  std::int64_t Data(int f, int view) const {
    return std::llround(
        unit_ * areas_[f] *
        std::min(20.0, std::log(best_[f] / FindCandidate(candidates_[f], view)->quality)));
  }
  /// The colour of a view along a border, from those adjacent faces that it sees. Distances between
  /// such points satisfy the triangle inequality, which expansion requires.
  Vector3f ColorAlong(const Border& border, int view) const {
    const LabelCandidate *a = FindCandidate(candidates_[border.a], view),
                         *b = FindCandidate(candidates_[border.b], view);
    if (a && b) return 0.5f * (a->color + b->color);
    if (a) return a->color;
    return b ? b->color : Vector3f::Zero().eval();
  }
  std::int64_t Gap(const Border& border, int l, int m) const {
    if (l == m) return 0;
    return std::llround(
        unit_ * border.cost *
        (1 + (ColorAlong(border, l) - ColorAlong(border, m)).norm() / LabelTuning::kColorStep));
  }
  void AddBorder(const Border& border, int view, MinCut& cut) const {
    const int p = node_[border.a], q = node_[border.b];
    const int lp = labels_[border.a], lq = labels_[border.b];
    if (p < 0) return cut.AddTerminals(q, Gap(border, lp, lq), Gap(border, lp, view));
    if (q < 0) return cut.AddTerminals(p, Gap(border, lp, lq), Gap(border, view, lq));
    const std::int64_t both_keep = Gap(border, lp, lq), only_p = Gap(border, view, lq),
                       only_q = Gap(border, lp, view);
    cut.AddTerminals(p, std::max<std::int64_t>(0, both_keep - only_p),
                     std::max<std::int64_t>(0, only_p - both_keep));
    cut.AddTerminals(q, only_p, 0);
    // Rounding may violate the triangle inequality by one unit.
    cut.AddEdge(q, p, std::max<std::int64_t>(0, only_p + only_q - both_keep), 0);
  }

  const Candidates& candidates_;
  std::vector<Border> borders_;
  double unit_ = 1;
  Eigen::VectorXd areas_;
  std::vector<double> best_;
  std::vector<int> labels_, node_;
  std::vector<std::vector<int>> borders_of_, faces_of_;  ///< for each face, for each view
};

void KeepBest(int most, std::vector<LabelCandidate>& list) {
  std::sort(list.begin(), list.end(), [](const LabelCandidate& a, const LabelCandidate& b) {
    return std::pair(-a.quality, a.view) < std::pair(-b.quality, b.view);
  });
  if (SizeOf(list) > most) list.resize(most);
  std::sort(list.begin(), list.end(),
            [](const LabelCandidate& a, const LabelCandidate& b) { return a.view < b.view; });
}

}  // namespace

const LabelCandidate* FindCandidate(const std::vector<LabelCandidate>& ascending, int view) {
  const auto at = std::lower_bound(ascending.begin(), ascending.end(), view,
                                   [](const LabelCandidate& c, int v) { return c.view < v; });
  return at != ascending.end() && at->view == view ? &*at : nullptr;
}

std::vector<int> ChooseLabels(const Mesh& mesh, std::vector<std::vector<LabelCandidate>> candidates,
                              const LabelOptions& options) {
  int views = 0;
  for (auto& list : candidates) {
    KeepBest(options.most_candidates, list);
    if (!list.empty()) views = std::max(views, list.back().view + 1);
  }
  Expansion expansion(mesh, candidates);
  // A view without changes is only tried again after another one had some.
  int idle = 0;
  for (int step = 0; step < options.sweeps * views && idle < views; ++step)
    idle = expansion.Expand(step % views) ? 0 : idle + 1;
  return expansion.labels();
}

std::vector<std::vector<LabelShare>> VertexShares(const Mesh& mesh,
                                                  const std::vector<int>& labels) {
  const Eigen::VectorXd areas = FaceAreas(mesh.points, mesh.faces);
  std::vector<std::map<int, double>> sums(mesh.vertex_count());
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k)
      if (labels[f] >= 0) sums[mesh.faces(f, k)][labels[f]] += std::max(areas[f], 1e-300);
  std::vector<std::vector<LabelShare>> shares(sums.size());
  for (std::size_t v = 0; v < sums.size(); ++v) {
    double total = 0;
    for (const auto& [view, area] : sums[v]) total += area;
    for (const auto& [view, area] : sums[v])
      shares[v].push_back({view, static_cast<float>(area / total)});
  }
  return shares;
}

}  // namespace keypose::texture
