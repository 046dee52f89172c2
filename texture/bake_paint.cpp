#include "texture/bake_paint.h"

#include <algorithm>
#include <cmath>
#include <mutex>
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

/// Less than this share of the weight is not looked at: it is not seen, but would cost as much as all of it.
constexpr float kLeastShare = 0.02f;

/// One view of a face with its parts at the corners.
struct Painted {
  FaceSight sight;
  Vector3f weight;        ///< in the mean of all views
  Vector3f share;         ///< in the detail
  Eigen::Matrix3f shift;  ///< of its colour as detail, times the share; a column a corner
};
struct FaceWork {
  std::vector<Painted> views;
  Vector3f weight;  ///< sum over the views
  Vector3f share;
  bool doubt = false;
  std::vector<Vote> votes;  ///< scratch
};

/// All that is known once the views are chosen.
class Painter {
 public:
  Painter(const Witnesses& witnesses, const PaintOptions& options)
      : witnesses_(witnesses), mesh_(witnesses.mesh()), detail_step_(options.detail_step), faces_(witnesses.LookAtFaces()) {
    std::vector<std::vector<LabelCandidate>> candidates(faces_.size());
    for (std::size_t f = 0; f < faces_.size(); ++f) candidates[f] = faces_[f].candidates;
    labels_ = ChooseLabels(mesh_, std::move(candidates));
    shares_ = VertexShares(mesh_, labels_);
    shifts_ = LevelSeams(mesh_, faces_, labels_, shares_, options.to_mean);
    FindDoubts();
    SpreadWeights();
  }

  void PrepareFace(int face, FaceWork& work) const {
    work.views.clear();
    work.weight.setZero();
    work.share.setZero();
    work.doubt = false;
    for (const LabelCandidate& candidate : faces_[face].candidates) {
      Painted painted;
      painted.weight = painted.share = Vector3f::Zero();
      painted.shift.setZero();
      for (int k = 0; k < 3; ++k) AddCorner(mesh_.faces(face, k), k, candidate, painted, work.doubt);
      if (!witnesses_.Prepare(candidate.view, face, painted.sight)) continue;
      work.weight += painted.weight;
      work.share += painted.share;
      work.views.push_back(painted);
    }
  }

  /// False when no view sees the point.
  bool Color(const SurfacePoint& point, FaceWork& work, Vector3f& color, std::vector<char>& used) const {
    if (work.doubt)
      witnesses_.CollectVotes(point, 1, work.votes);
    else
      work.votes.clear();
    Vector3f mean = Vector3f::Zero(), detail = Vector3f::Zero(), seen;
    float mean_sum = 0, detail_sum = 0;
    const float least_weight = kLeastShare * work.weight.dot(point.weights), least_share = kLeastShare * work.share.dot(point.weights);
    for (const Painted& view : work.views) {
      float weight = view.weight.dot(point.weights), share = view.share.dot(point.weights);
      if (weight <= least_weight && share <= least_share) continue;
      const float trust = witnesses_.Look(view.sight, point, seen);
      if (trust <= 0) continue;
      used[view.sight.view] = 1;
      const float agreement = work.votes.empty() ? 1 : AgreementOf(view.sight.view, work.votes);
      mean += agreement * trust * weight * seen;
      mean_sum += agreement * trust * weight;
      if (share <= least_share) continue;
      detail += agreement * (share * seen + view.shift * point.weights);
      detail_sum += agreement * share;
    }
    if (!(mean_sum > 0)) return Rest(point, color, used, work.votes);
    color = Mixed(mean / mean_sum, detail, detail_sum, kMeanWeight * work.share.dot(point.weights) * static_cast<float>(work.doubt));
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
  struct VertexWeight {
    int view;
    float weight;
  };

  void AddCorner(int v, int corner, const LabelCandidate& candidate, Painted& painted, bool& doubt) const {
    for (const VertexWeight& w : weights_[v])
      if (w.view == candidate.view) painted.weight[corner] = w.weight;
    for (std::size_t i = 0; i < shares_[v].size(); ++i) {
      if (shares_[v][i].view != candidate.view) continue;
      // A view that was chosen beside this face may have a highlight on it.
      painted.share[corner] = shares_[v][i].share * candidate.agreement;
      painted.shift.col(corner) = painted.share[corner] * shifts_[v][i].color;
      doubt |= least_agreement_[v][i] < kSure;
    }
  }

  /// The detail as far as the mean of all views bears it out. Where photographs show something else in one place (hairs, wrong cameras), no
  /// single one of them is right, and all together are nearest to the next photograph.
  Vector3f Mixed(const Vector3f& mean, Vector3f detail, float sum, float mean_weight) const {
    if (!(sum > 0)) return mean;
    detail = ((detail + mean_weight * mean) / (sum + mean_weight)).cwiseMax(0.0f);
    if (!std::isfinite(detail_step_)) return detail;
    const float apart = (detail.cwiseSqrt() - mean.cwiseSqrt()).squaredNorm();
    return mean + std::exp(-0.5f * apart / std::max(detail_step_ * detail_step_, 1e-12f)) * (detail - mean);
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

  /// Each view's weight in the mean at the vertices, so that it changes smoothly over the surface.
  void SpreadWeights() {
    const Eigen::VectorXd areas = FaceAreas(mesh_.points, mesh_.faces);
    weights_.resize(mesh_.vertex_count());
    for (int f = 0; f < mesh_.face_count(); ++f)
      for (int k = 0; k < 3; ++k)
        for (const LabelCandidate& candidate : faces_[f].candidates) {
          auto& list = weights_[mesh_.faces(f, k)];
          const auto at = std::find_if(list.begin(), list.end(), [&](const VertexWeight& w) { return w.view == candidate.view; });
          const float weight = static_cast<float>(std::max(areas[f], 1e-300) * candidate.weight);
          if (at == list.end())
            list.push_back({candidate.view, weight});
          else
            at->weight += weight;
        }
    std::vector<double> ring(mesh_.vertex_count(), 0);
    for (int f = 0; f < mesh_.face_count(); ++f)
      for (int k = 0; k < 3; ++k) ring[mesh_.faces(f, k)] += std::max(areas[f], 1e-300);
    for (int v = 0; v < mesh_.vertex_count(); ++v)
      for (VertexWeight& w : weights_[v]) w.weight = static_cast<float>(w.weight / ring[v]);
  }

  static float AgreementOf(int view, const std::vector<Vote>& votes) {
    for (const Vote& vote : votes)
      if (vote.view == view) return vote.agreement;
    return 1e-6f;
  }

  /// A texel that is seen only by views that see none of the points at which its face was judged.
  bool Rest(const SurfacePoint& point, Vector3f& color, std::vector<char>& used, std::vector<Vote>& votes) const {
    witnesses_.CollectVotes(point, 1, votes);
    float sum = 0;
    Vector3f mean = Vector3f::Zero();
    for (const Vote& vote : votes) {
      mean += vote.weight * vote.agreement * vote.fine;
      sum += vote.weight * vote.agreement;
      used[vote.view] = 1;
    }
    if (!(sum > 0)) return false;
    color = mean / sum;
    return true;
  }

  const Witnesses& witnesses_;
  const Mesh& mesh_;
  float detail_step_;
  std::vector<FaceViews> faces_;
  std::vector<int> labels_;
  std::vector<std::vector<LabelShare>> shares_;
  std::vector<std::vector<Shift>> shifts_;
  std::vector<std::vector<float>> least_agreement_;  ///< beside shares_
  std::vector<std::vector<VertexWeight>> weights_;   ///< of each vertex
};

/// What one block of faces adds to the result.
struct Tally {
  std::int64_t seen = 0;
  std::vector<char> used;
};

void PaintFace(const Painter& painter, const Mesh& mesh, const Atlas& atlas, int face, FaceWork& work, Painting& painting, Tally& tally) {
  const TexelBox box = TexelsAround(mesh, atlas, face);
  bool prepared = false;
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) {
      const std::size_t texel = static_cast<std::size_t>(y) * atlas.size + x;
      if (atlas.face[texel] != face) continue;
      if (!prepared) painter.PrepareFace(face, work);
      prepared = true;
      if (!painter.Color({face, atlas.Weights(texel)}, work, painting.color[texel], tally.used)) continue;
      painting.painted[texel] = 1;
      tally.seen += atlas.inside[texel];
    }
}

}  // namespace

PaintResult PaintTexels(const Witnesses& witnesses, const Atlas& atlas, const PaintOptions& options, Progress* progress) {
  Step(progress, 0, "choosing views");
  const Painter painter(witnesses, options);
  const Mesh& mesh = witnesses.mesh();
  PaintResult result;
  result.labels = painter.labels();
  result.mean_views = painter.MeanViews();
  result.painting.color.assign(atlas.face.size(), Vector3f::Zero());
  result.painting.painted.assign(atlas.face.size(), 0);
  result.used.assign(witnesses.view_count(), 0);
  std::mutex mutex;
  // Bands, so that progress is told and cancelling is possible between them.
  const std::int64_t faces = mesh.face_count(), band = std::max<std::int64_t>(1024, faces / 16 + 1);
  for (std::int64_t first = 0; first < faces; first += band) {
    Step(progress, 0.3 + 0.7 * static_cast<double>(first) / static_cast<double>(faces), "texels");
    ParallelBlocks(std::min(band, faces - first), 128, [&](std::int64_t begin, std::int64_t end) {
      FaceWork work;
      Tally tally{0, std::vector<char>(witnesses.view_count(), 0)};
      for (std::int64_t f = first + begin; f < first + end; ++f)
        PaintFace(painter, mesh, atlas, static_cast<int>(f), work, result.painting, tally);
      const std::lock_guard<std::mutex> lock(mutex);  // sums of integers: the same in any order
      result.seen_texels += tally.seen;
      for (int v = 0; v < witnesses.view_count(); ++v) result.used[v] |= tally.used[v];
    });
  }
  return result;
}

}  // namespace keypose::texture
