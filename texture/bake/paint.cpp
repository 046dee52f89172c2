#include "texture/bake/paint.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/tuned.h"
#include "texture/bake/lattice.h"
#include "texture/bake/seam_levelling.h"

namespace keypose::texture {
namespace {

using Eigen::Vector3f;

/// kSure and kMeanWeight: chosen on held-out photographs of the synthetic character, the plush dog
/// and the skull and on the glossy sphere of bake_test
/// (docs/algorithms/bake.md). kSureTrust: no record of the data.
struct PaintTuning {
  /// agreement in (0, 1]: if a chosen view's is lower on a face or beside it, every texel is
  /// compared with all views
  KEYPOSE_TUNED(float, kSure, 0.15f);
  /// weight of the mean of all views there, in shares of the chosen views: negligible where these
  /// agree, dominant where they do not
  KEYPOSE_TUNED(float, kMeanWeight, 0.02f);
  /// share of full trust: a texel with at least this in some view is fully confident; points closer
  /// to edges in all photographs may be background
  KEYPOSE_TUNED(float, kSureTrust, 0.5f);
};

std::uint8_t SureOf(float trust) {
  return static_cast<std::uint8_t>(
      1 + std::lround(254 * std::min(1.0f, trust / PaintTuning::kSureTrust)));
}

/// Photographs are bilinear between their pixels: with this distance of nodes nothing visible is
/// lost.
constexpr float kNodePixels = 0.7f;

/// Views with a smaller share of the weight are skipped: they are invisible but cost as much.
constexpr float kLeastShare = 0.02f;

/// One view of a face with its values at the corners.
struct Painted {
  FaceSight sight;
  float agreement = 1;    ///< of its weight: agreement with the other views over the face
  Vector3f weight;        ///< in the mean of all views
  Vector3f share;         ///< in the detail
  Eigen::Matrix3f shift;  ///< shift of its colour as detail, times the share; one column per corner
};
/// A texel of a face.
struct FaceTexel {
  std::size_t texel = 0;
  Vector3f weights;  ///< barycentric
};
/// A point of a face, its sums over the views so far, and finally its colour.
struct PointWork {
  Vector3f weights;  ///< barycentric
  float least_weight = 0, least_share = 0;
  Vector3f mean = Vector3f::Zero(), detail = Vector3f::Zero();
  float mean_sum = 0, detail_sum = 0;
  float trust = 0;  ///< the largest over the views
  Vector3f color = Vector3f::Zero();
  bool seen = false;

  explicit PointWork(const Vector3f& w) : weights(w) {}
};
struct FaceWork {
  std::vector<FaceTexel> texels;
  std::vector<PointWork> points;
  std::vector<Painted> views;
  Vector3f weight;  ///< sum over the views
  Vector3f share;
  Vector3f doubt;                ///< at the corners: 1 where a chosen view is an outlier, else 0
  std::vector<float> agreement;  ///< of each point's views; empty without doubt
  std::vector<ColorSample> samples;  ///< scratch
};

/// The data for painting once the views are chosen.
class Painter {
 public:
  Painter(const ColorSampler& sampler, const PaintOptions& options)
      : sampler_(sampler),
        mesh_(sampler.mesh()),
        detail_step_(options.detail_step),
        faces_(sampler.LookAtFaces()) {
    std::vector<std::vector<LabelCandidate>> candidates(faces_.size());
    for (std::size_t f = 0; f < faces_.size(); ++f) candidates[f] = faces_[f].candidates;
    labels_ = ChooseLabels(mesh_, std::move(candidates));
    shares_ = VertexShares(mesh_, labels_);
    shifts_ = LevelSeams(mesh_, faces_, labels_, shares_, options.to_mean);
    FindDoubts();
    SpreadWeights();
  }

  /// Paints the texels in `work`, all of this face.
  void PaintFace(int face, FaceWork& work, Painting& painting, std::vector<char>& used) const {
    PrepareFace(face, work);
    const int parts = LatticeParts(work);
    if (2 * FaceLattice::CountOf(parts) < std::ssize(work.texels))
      PaintLattice(face, FaceLattice(parts), work, painting, used);
    work.points.clear();
    for (const FaceTexel& texel : work.texels) work.points.emplace_back(texel.weights);
    ColorPoints(face, work, used);
    for (std::size_t i = 0; i < work.texels.size(); ++i) {
      painting.At(work.texels[i].texel) = work.points[i].color;
      painting.sure[work.texels[i].texel] = work.points[i].seen ? SureOf(work.points[i].trust) : 0;
    }
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

  void PrepareFace(int face, FaceWork& work) const {
    work.views.clear();
    work.weight.setZero();
    work.share.setZero();
    for (int k = 0; k < 3; ++k) work.doubt[k] = doubt_[mesh_.faces(face, k)];
    for (const LabelCandidate& candidate : faces_[face].candidates) {
      Painted painted;
      painted.weight = painted.share = Vector3f::Zero();
      painted.shift.setZero();
      painted.agreement = candidate.mean_agreement;
      for (int k = 0; k < 3; ++k) AddCorner(mesh_.faces(face, k), k, candidate, painted);
      if (!sampler_.Prepare(candidate.view, face, painted.sight)) continue;
      work.weight += painted.weight;
      work.share += painted.share;
      work.views.push_back(painted);
    }
  }

  /// Number of parts per side, so that photographs have no detail between the nodes.
  static int LatticeParts(const FaceWork& work) {
    float longest = 0;
    for (const Painted& view : work.views)
      for (int k = 0; k < 3; ++k)
        longest = std::max(
            longest, (view.sight.pixels.col(k) - view.sight.pixels.col((k + 1) % 3)).squaredNorm());
    return 1 + static_cast<int>(std::min(1000.0f, std::sqrt(longest) / kNodePixels));
  }

  /// For texels much smaller than the photographs' pixels: colours at the nodes, interpolated
  /// linearly. Texels next to an unseen node are left in `work`.
  void PaintLattice(int face, const FaceLattice& lattice, FaceWork& work, Painting& painting,
                    std::vector<char>& used) const {
    work.points.clear();
    lattice.ForNodes([&](const Vector3f& weights) { work.points.emplace_back(weights); });
    ColorPoints(face, work, used);
    std::erase_if(work.texels, [&](const FaceTexel& texel) {
      const FaceLattice::Corners at = lattice.Between(texel.weights);
      Vector3f color = Vector3f::Zero();
      float trust = 0;
      for (int k = 0; k < 3; ++k) {
        if (!work.points[at.node[k]].seen) return false;
        color += at.weight[k] * work.points[at.node[k]].color;
        trust += at.weight[k] * work.points[at.node[k]].trust;
      }
      painting.At(texel.texel) = color;
      painting.sure[texel.texel] = SureOf(trust);
      return true;
    });
  }

  void ColorPoints(int face, FaceWork& work, std::vector<char>& used) const {
    if (work.points.empty()) return;
    for (PointWork& point : work.points) {
      point.least_weight = kLeastShare * work.weight.dot(point.weights);
      point.least_share = kLeastShare * work.share.dot(point.weights);
    }
    AskForAgreement(face, work);
    for (std::size_t i = 0; i < work.views.size(); ++i)
      AddView(face, static_cast<int>(i), work, used);
    for (PointWork& point : work.points) {
      point.seen = point.mean_sum > 0 || Rest({face, point.weights}, point, used, work.samples);
      if (point.mean_sum > 0)
        point.color = Mixed(point.mean / point.mean_sum, point.detail, point.detail_sum,
                            PaintTuning::kMeanWeight * work.share.dot(point.weights) *
                                work.doubt.dot(point.weights));
    }
  }

  /// Compares each point of a doubtful face with all views. The loss of weight increases from zero
  /// at the border of the doubt, so that no edge is visible there.
  void AskForAgreement(int face, FaceWork& work) const {
    work.agreement.clear();
    if (work.doubt.isZero()) return;
    for (const PointWork& point : work.points) {
      sampler_.CollectColorSamples({face, point.weights}, 1, work.samples);
      const float doubt = work.doubt.dot(point.weights);
      for (const Painted& view : work.views)
        work.agreement.push_back(std::pow(AgreementOf(view.sight.view, work.samples), doubt));
    }
  }

  void AddView(int face, int which, FaceWork& work, std::vector<char>& used) const {
    const Painted& view = work.views[which];
    Vector3f seen;
    for (std::size_t j = 0; j < work.points.size(); ++j) {
      PointWork& point = work.points[j];
      const float weight = view.weight.dot(point.weights), share = view.share.dot(point.weights);
      if (weight <= point.least_weight && share <= point.least_share) continue;
      const float trust = sampler_.Look(view.sight, {face, point.weights}, seen);
      if (trust <= 0) continue;
      used[view.sight.view] = 1;
      point.trust = std::max(point.trust, trust);
      const float agreement =
          work.agreement.empty() ? 1 : work.agreement[j * work.views.size() + which];
      // The weight includes the agreement over the face, so it is only reduced where the agreement
      // at the point is lower.
      const float part = trust * weight * std::min(1.0f, agreement / view.agreement);
      point.mean += part * seen;
      point.mean_sum += part;
      if (share <= point.least_share) continue;
      point.detail += agreement * (share * seen + view.shift * point.weights);
      point.detail_sum += agreement * share;
    }
  }

  void AddCorner(int v, int corner, const LabelCandidate& candidate, Painted& painted) const {
    for (const VertexWeight& w : weights_[v])
      if (w.view == candidate.view) painted.weight[corner] = w.weight;
    for (std::size_t i = 0; i < shares_[v].size(); ++i) {
      if (shares_[v][i].view != candidate.view) continue;
      // A view that was chosen for an adjacent face may have a highlight on this one.
      painted.share[corner] = shares_[v][i].share * candidate.agreement;
      painted.shift.col(corner) = painted.share[corner] * shifts_[v][i].color;
    }
  }

  /// The detail as far as it agrees with the mean of all views. Where photographs show different
  /// things at one point (hairs, wrong cameras), no single one is right, and the mean predicts
  /// other photographs best.
  Vector3f Mixed(const Vector3f& mean, Vector3f detail, float sum, float mean_weight) const {
    if (!(sum > 0)) return mean;
    detail = ((detail + mean_weight * mean) / (sum + mean_weight)).cwiseMax(0.0f);
    if (!std::isfinite(detail_step_)) return detail;
    const float apart = (detail.cwiseSqrt() - mean.cwiseSqrt()).squaredNorm();
    return mean + std::exp(-0.5f * apart / std::max(detail_step_ * detail_step_, 1e-12f)) *
                      (detail - mean);
  }

  /// Marks the corners of all faces at vertices around which one of the vertex's views is an
  /// outlier on some face: outliers are in full doubt, which ends beyond them.
  void FindDoubts() {
    std::vector<char> contradicted(shares_.size(), 0);
    for (int f = 0; f < mesh_.face_count(); ++f)
      for (int k = 0; k < 3; ++k)
        for (const LabelShare& share : shares_[mesh_.faces(f, k)]) {
          const LabelCandidate* here = FindCandidate(faces_[f].candidates, share.view);
          if (here && here->agreement < PaintTuning::kSure) contradicted[mesh_.faces(f, k)] = 1;
        }
    doubt_.assign(shares_.size(), 0);
    for (int f = 0; f < mesh_.face_count(); ++f) {
      const auto v = mesh_.faces.row(f);
      if (contradicted[v[0]] || contradicted[v[1]] || contradicted[v[2]])
        for (int k = 0; k < 3; ++k) doubt_[v[k]] = 1;
    }
  }

  /// Computes each view's weight in the mean at the vertices, so that it varies smoothly over the
  /// surface.
  void SpreadWeights() {
    const Eigen::VectorXd areas = FaceAreas(mesh_.points, mesh_.faces);
    weights_.resize(mesh_.vertex_count());
    for (int f = 0; f < mesh_.face_count(); ++f)
      for (int k = 0; k < 3; ++k)
        for (const LabelCandidate& candidate : faces_[f].candidates) {
          auto& list = weights_[mesh_.faces(f, k)];
          const auto at = std::find_if(list.begin(), list.end(), [&](const VertexWeight& w) {
            return w.view == candidate.view;
          });
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

  static float AgreementOf(int view, const std::vector<ColorSample>& samples) {
    for (const ColorSample& sample : samples)
      if (sample.view == view) return sample.agreement;
    return 1e-6f;
  }

  /// For a texel that is only seen by views that see none of its face's sample points.
  bool Rest(const SurfacePoint& place, PointWork& point, std::vector<char>& used,
            std::vector<ColorSample>& samples) const {
    sampler_.CollectColorSamples(place, 1, samples);
    float sum = 0;
    Vector3f mean = Vector3f::Zero();
    for (const ColorSample& sample : samples) {
      mean += sample.weight * sample.agreement * sample.fine;
      sum += sample.weight * sample.agreement;
      point.trust = std::max(point.trust, sample.trust);
      used[sample.view] = 1;
    }
    if (!(sum > 0)) return false;
    point.color = mean / sum;
    return true;
  }

  const ColorSampler& sampler_;
  const Mesh& mesh_;
  float detail_step_;
  std::vector<FaceViews> faces_;
  std::vector<int> labels_;
  std::vector<std::vector<LabelShare>> shares_;
  std::vector<std::vector<Shift>> shifts_;
  std::vector<float> doubt_;                        ///< 1 or 0, for each vertex
  std::vector<std::vector<VertexWeight>> weights_;  ///< for each vertex
};

void PaintFace(const Painter& painter, const Atlas& atlas, int face, FaceWork& work,
               Painting& painting, std::vector<char>& used) {
  const TexelBox box = TexelsAround(atlas, face);
  work.texels.clear();
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) {
      const std::size_t texel = static_cast<std::size_t>(y) * atlas.size + x;
      if (atlas.face[texel] == face) work.texels.push_back({texel, atlas.Weights(texel)});
    }
  if (!work.texels.empty()) painter.PaintFace(face, work, painting, used);
}

/// Number of painted texels with their centre in a triangle.
std::int64_t CountSeen(const Atlas& atlas, const Painting& painting) {
  std::int64_t seen = 0;
  for (std::size_t texel = 0; texel < atlas.inside.size(); ++texel)
    seen += painting.sure[texel] && atlas.inside[texel];
  return seen;
}

}  // namespace

PaintResult PaintTexels(const ColorSampler& sampler, const Atlas& atlas,
                        const PaintOptions& options, Progress* progress) {
  ReportProgress(progress, 0, "choosing views");
  const Painter painter(sampler, options);
  const Mesh& mesh = sampler.mesh();
  PaintResult result;
  result.labels = painter.labels();
  result.mean_views = painter.MeanViews();
  result.painting = Painting(atlas.size);
  result.used.assign(sampler.view_count(), 0);
  std::mutex mutex;
  // In bands, for progress reports and cancellation between them.
  const std::int64_t faces = mesh.face_count(), band = std::max<std::int64_t>(1024, faces / 16 + 1);
  for (std::int64_t first = 0; first < faces; first += band) {
    ReportProgress(progress, 0.3 + 0.7 * static_cast<double>(first) / static_cast<double>(faces),
                   "texels");
    ParallelBlocks(std::min(band, faces - first), 128, [&](std::int64_t begin, std::int64_t end) {
      FaceWork work;
      std::vector<char> used(sampler.view_count(), 0);
      for (std::int64_t f = first + begin; f < first + end; ++f)
        PaintFace(painter, atlas, static_cast<int>(f), work, result.painting, used);
      const std::lock_guard<std::mutex> lock(mutex);  // the result does not depend on the order
      for (int v = 0; v < sampler.view_count(); ++v) result.used[v] |= used[v];
    });
  }
  result.seen_texels = CountSeen(atlas, result.painting);
  return result;
}

}  // namespace keypose::texture
