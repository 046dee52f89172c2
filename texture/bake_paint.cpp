#include "texture/bake_paint.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "core/geometry.h"
#include "core/parallel.h"
#include "texture/bake_seams.h"

namespace keypose::texture {
namespace {

using Eigen::Vector3f;

/// Where a chosen view agrees less than this with the others, on a face or beside it, every texel is put to the vote.
constexpr float kSure = 0.15f;
/// Weight of the mean of all views there: a trace where the chosen view agrees, everything where it does not.
constexpr float kMeanWeight = 0.02f;

/// The views that are mixed at one texel, each with its shift times its weight.
struct Mixture {
  static constexpr int kMost = 12;
  int count = 0;
  std::array<int, kMost> view;
  std::array<float, kMost> weight;
  std::array<Vector3f, kMost> shift;

  void Add(int v, float w, const Vector3f& s) {
    int i = 0;
    while (i < count && view[i] != v) ++i;
    if (i == kMost) return;
    if (i == count) view[i] = v, weight[i] = 0, shift[i].setZero(), ++count;
    weight[i] += w;
    shift[i] += w * s;
  }
};

/// All that is known once the views are chosen.
class Painter {
 public:
  Painter(const Witnesses& witnesses, double to_mean) : witnesses_(witnesses), mesh_(witnesses.mesh()), faces_(witnesses.LookAtFaces()) {
    std::vector<std::vector<LabelCandidate>> candidates(faces_.size());
    for (std::size_t f = 0; f < faces_.size(); ++f) candidates[f] = faces_[f].candidates;
    labels_ = ChooseLabels(mesh_, std::move(candidates));
    shares_ = VertexShares(mesh_, labels_);
    shifts_ = LevelSeams(mesh_, faces_, labels_, shares_, to_mean);
    FindDoubts();
  }

  /// False when no view sees the point.
  bool Color(const SurfacePoint& point, Vector3f& color, std::vector<char>& used, std::vector<Vote>& votes) const {
    bool doubt = false;
    const Mixture mixture = MixtureAt(point, doubt);
    Vector3f total = Vector3f::Zero(), seen;
    float sum = 0;
    if (doubt)
      witnesses_.CollectVotes(point, 1, votes);
    else
      votes.clear();
    const float all = std::accumulate(mixture.weight.begin(), mixture.weight.begin() + mixture.count, 0.0f);
    for (int i = 0; i < mixture.count; ++i) {
      // A hundredth of the colour is not seen, but would cost as much as all of it.
      if (mixture.weight[i] < 0.01f * all || !witnesses_.Look(mixture.view[i], point, seen)) continue;
      const float agreement = doubt ? AgreementOf(mixture.view[i], votes) : 1;
      total += agreement * (mixture.weight[i] * seen + mixture.shift[i]);
      sum += agreement * mixture.weight[i];
      used[mixture.view[i]] = 1;
    }
    AddMean(votes, kMeanWeight * all, total, sum);
    if (sum > 0)
      total /= sum;
    else if (!SecondChoice(point, total, used))
      return false;
    color = total.cwiseMax(0.0f);
    return true;
  }

  double MeanViews() const {
    const Eigen::VectorXd areas = FaceAreas(mesh_.points, mesh_.faces);
    double views = 0, area = 0;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (faces_[f].candidates.empty()) continue;
      for (const LabelCandidate& c : faces_[f].candidates) views += areas[f] * c.seen;
      area += areas[f];
    }
    return area > 0 ? views / area : 0;
  }

  const std::vector<int>& labels() const { return labels_; }

 private:
  Mixture MixtureAt(const SurfacePoint& point, bool& doubt) const {
    Mixture mixture;
    for (int k = 0; k < 3; ++k) {
      const int v = mesh_.faces(point.face, k);
      for (std::size_t i = 0; i < shares_[v].size(); ++i) {
        // A view that was chosen beside this face may have a highlight on it.
        const LabelCandidate* here = FindCandidate(faces_[point.face].candidates, shares_[v][i].view);
        if (!here) continue;
        mixture.Add(here->view, std::max(point.weights[k], 0.0f) * shares_[v][i].share * here->agreement, shifts_[v][i].color);
        doubt |= least_agreement_[v][i] < kSure;
      }
    }
    return mixture;
  }

  /// The least agreement of each vertex's views on the faces around it.
  void FindDoubts() {
    least_agreement_.resize(shares_.size());
    for (std::size_t v = 0; v < shares_.size(); ++v) least_agreement_[v].assign(shares_[v].size(), 1);
    for (int f = 0; f < mesh_.face_count(); ++f)
      for (int k = 0; k < 3; ++k) {
        const int v = mesh_.faces(f, k);
        for (std::size_t i = 0; i < shares_[v].size(); ++i)
          if (const LabelCandidate* here = FindCandidate(faces_[f].candidates, shares_[v][i].view))
            least_agreement_[v][i] = std::min(least_agreement_[v][i], here->agreement);
      }
  }

  static float AgreementOf(int view, const std::vector<Vote>& votes) {
    for (const Vote& vote : votes)
      if (vote.view == view) return vote.agreement;
    return 1e-6f;
  }

  static void AddMean(const std::vector<Vote>& votes, float weight, Vector3f& total, float& sum) {
    float all = 0;
    Vector3f mean = Vector3f::Zero();
    for (const Vote& vote : votes) {
      mean += vote.weight * vote.agreement * vote.fine;
      all += vote.weight * vote.agreement;
    }
    if (all <= 0) return;
    total += weight / all * mean;
    sum += weight;
  }

  bool SecondChoice(const SurfacePoint& point, Vector3f& color, std::vector<char>& used) const {
    std::vector<LabelCandidate> best_first = faces_[point.face].candidates;
    std::sort(best_first.begin(), best_first.end(), [](const LabelCandidate& a, const LabelCandidate& b) {
      return std::pair(-a.quality, a.view) < std::pair(-b.quality, b.view);
    });
    for (const LabelCandidate& candidate : best_first) {
      if (!witnesses_.Look(candidate.view, point, color)) continue;
      color += faces_[point.face].mean - candidate.linear;
      used[candidate.view] = 1;
      return true;
    }
    return false;
  }

  const Witnesses& witnesses_;
  const Mesh& mesh_;
  std::vector<FaceViews> faces_;
  std::vector<int> labels_;
  std::vector<std::vector<LabelShare>> shares_;
  std::vector<std::vector<Shift>> shifts_;
  std::vector<std::vector<float>> least_agreement_;  ///< beside shares_
};

}  // namespace

PaintResult PaintTexels(const Witnesses& witnesses, const Atlas& atlas, double to_mean, Progress* progress) {
  Step(progress, 0, "choosing views");
  const Painter painter(witnesses, to_mean);
  PaintResult result;
  result.labels = painter.labels();
  result.mean_views = painter.MeanViews();
  result.painting.color.assign(atlas.face.size(), Vector3f::Zero());
  result.painting.painted.assign(atlas.face.size(), 0);
  std::vector<std::int64_t> seen(atlas.size, 0);
  std::vector<std::vector<char>> used(atlas.size);
  // Bands, so that progress is told and cancelling is possible between them.
  const int band = std::max(16, atlas.size / 16);
  for (int first = 0; first < atlas.size; first += band) {
    Step(progress, 0.3 + 0.7 * first / atlas.size, "texels");
    ParallelFor(std::min(band, atlas.size - first), [&](std::int64_t offset) {
      const int y = first + static_cast<int>(offset);
      used[y].assign(witnesses.view_count(), 0);
      std::vector<Vote> votes;
      for (int x = 0; x < atlas.size; ++x) {
        const std::size_t texel = static_cast<std::size_t>(y) * atlas.size + x;
        if (atlas.face[texel] < 0) continue;
        if (!painter.Color({atlas.face[texel], atlas.Weights(texel)}, result.painting.color[texel], used[y], votes)) continue;
        result.painting.painted[texel] = 1;
        seen[y] += atlas.inside[texel];
      }
    });
  }
  result.used.assign(witnesses.view_count(), 0);
  for (int y = 0; y < atlas.size; ++y) {
    result.seen_texels += seen[y];
    for (int v = 0; v < witnesses.view_count(); ++v) result.used[v] |= used[y][v];
  }
  return result;
}

}  // namespace keypose::texture
