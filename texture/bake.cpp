#include "texture/bake.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/parallel.h"
#include "texture/bake_atlas.h"
#include "texture/bake_gain.h"
#include "texture/bake_quality.h"

namespace keypose::texture {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// Large-scale colour is what remains when the photograph is averaged over 2^3 pixels each way.
constexpr double kBandLevels = 3;
/// Views support each other when their colours (square root of linear light) are about this near: noise, and shading that turns with the
/// table.
constexpr float kLikeness = 0.1f;

/// What one view says of one texel.
struct Vote {
  Vector3f fine, low;       ///< linear light, gain applied
  Vector3f root, low_root;  ///< their square roots: steps of about equal visibility. A highlight shows in the low band beyond its rim
  float weight;             ///< resolution, angle, trust, sharpness: its part of the blend
  float say;  ///< its part in what the views agree upon; flatter, since the view from straight ahead may be the one that sees the lamp
  float agreement = 1;  ///< with the other views, (0, 1]
  int view;
};

/// Lowers the agreement of votes that few others support.
///
/// Support is the share of the say that lies near a vote's colour. Unlike a distance to the median it changes smoothly along the surface:
/// where lit and shaded views are about equally many both stay, and no seam appears where the majority turns.
void WeighAgreement(std::vector<Vote>& votes, double strictness) {
  if (votes.size() < 2 || strictness <= 0) return;
  float most = 0;
  for (Vote& vote : votes) {
    float support = 0;
    for (const Vote& other : votes) {
      const float apart = (vote.root - other.root).squaredNorm() + (vote.low_root - other.low_root).squaredNorm();
      support += other.say * std::exp(-0.5f * apart / (kLikeness * kLikeness));
    }
    vote.agreement = support;
    most = std::max(most, support);
  }
  for (Vote& vote : votes) vote.agreement = static_cast<float>(std::pow(vote.agreement / most, strictness));
}

/// Low band as the mean of all, high band from the best.
Vector3f Blend(const std::vector<Vote>& votes, double detail_exponent) {
  float best = 0;
  for (const Vote& vote : votes) best = std::max(best, vote.weight * vote.agreement);
  Vector3f low = Vector3f::Zero(), high = Vector3f::Zero();
  float low_sum = 0, high_sum = 0;
  for (const Vote& vote : votes) {
    const float soft = vote.weight * vote.agreement;
    const float sharp = static_cast<float>(std::pow(soft / best, detail_exponent));
    low += soft * vote.low;
    low_sum += soft;
    high += sharp * (vote.fine - vote.low);
    high_sum += sharp;
  }
  return (low / low_sum + high / high_sum).cwiseMax(0.0f);
}

/// Everything that painting a texel needs.
class Painter {
 public:
  Painter(const Mesh& mesh, const Atlas& atlas, const std::vector<BakeView>& views, const std::vector<Vector3f>& gains,
          const BakeOptions& options)
      : mesh_(mesh),
        atlas_(atlas),
        views_(views),
        gains_(gains),
        options_(options),
        least_cosine_(std::cos(options.max_angle * M_PI / 180)) {
    face_normals_ = FaceNormals(mesh.points, mesh.faces);
    vertex_normals_ = VertexNormals(mesh.points, mesh.faces);
    FindCandidates();
    WeighSharpness();
    MeasureTexels();
  }

  /// Empty when no view sees the texel.
  void CollectVotes(std::size_t texel, std::vector<Vote>& votes) const {
    votes.clear();
    const int face = atlas_.face[texel];
    const Vector3d w = atlas_.Weights(texel).cast<double>();
    Vector3d x = Vector3d::Zero(), smooth = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      x += w[k] * mesh_.points.row(mesh_.faces(face, k)).transpose();
      smooth += w[k] * vertex_normals_.row(mesh_.faces(face, k)).transpose();
    }
    const Vector3d flat = face_normals_.row(face);
    smooth = smooth.squaredNorm() > 1e-12 ? smooth.normalized().eval() : flat;
    for (const int v : candidates_[face]) {
      const Vector3d to_eye = (views_[v].center() - x).normalized();
      if (flat.dot(to_eye) < least_cosine_) continue;
      const Sighting sighting = views_[v].See(x);
      if (sighting.trust > 0) AddVote(v, face, sighting, std::max(smooth.dot(to_eye), least_cosine_), votes);
    }
  }

  Vector3f Color(std::vector<Vote>& votes) const {
    WeighAgreement(votes, options_.strictness);
    return Blend(votes, options_.detail_exponent);
  }

 private:
  void AddVote(int v, int face, const Sighting& sighting, double cosine, std::vector<Vote>& votes) const {
    const double focal = views_[v].view().camera.fx / sighting.depth;
    const double pixels_per_texel = focal * focal * cosine * area_per_texel_[face];
    const double level = 0.5 * std::log2(std::max(pixels_per_texel, 1.0));
    const Sample fine = views_[v].ColorAt(sighting.pixel, level), low = views_[v].ColorAt(sighting.pixel, level + kBandLevels);
    if (fine.alpha <= 0 || low.alpha <= 0) return;
    Vote vote;
    vote.fine = fine.color.cwiseProduct(gains_[v]);
    vote.low = low.color.cwiseProduct(gains_[v]);
    vote.root = vote.fine.cwiseSqrt();
    vote.low_root = vote.low.cwiseSqrt();
    vote.weight = static_cast<float>(sighting.trust * pixels_per_texel * cosine * cosine * sharpness_[v]);
    vote.say = static_cast<float>(sighting.trust * std::min(1.0, 2 * cosine));
    // A clipped pixel tells only that the surface was at least this bright: a highlight, or an overexposed photograph.
    if (fine.color.minCoeff() > 0.9f) vote.weight *= 0.1f, vote.say *= 0.3f;
    vote.view = v;
    if (vote.weight > 0) votes.push_back(vote);
  }

  void FindCandidates() {
    candidates_.resize(mesh_.face_count());
    ParallelFor(
        mesh_.face_count(),
        [&](std::int64_t f) {
          const Vector3d n = face_normals_.row(f);
          for (int v = 0; v < static_cast<int>(views_.size()); ++v) {
            if (views_[v].sees_nothing() || IsHeldOut(v, options_)) continue;
            for (int k = 0; k < 3; ++k) {
              const Vector3d to_eye = views_[v].center() - mesh_.points.row(mesh_.faces(f, k)).transpose();
              // A corner may see the eye a little more aslant than the middle of a large face does.
              if (n.dot(to_eye) < (least_cosine_ - 0.1) * to_eye.norm()) continue;
              candidates_[f].push_back(v);
              break;
            }
          }
        },
        256);
  }

  void WeighSharpness() {
    std::vector<double> known;
    for (const BakeView& view : views_)
      if (view.sharpness() > 0) known.push_back(view.sharpness());
    sharpness_.assign(views_.size(), 1.0);
    if (known.empty()) return;
    std::nth_element(known.begin(), known.begin() + known.size() / 2, known.end());
    const double median = known[known.size() / 2];
    for (std::size_t v = 0; v < views_.size(); ++v)
      if (views_[v].sharpness() > 0) sharpness_[v] = std::clamp(views_[v].sharpness() / median, 0.2, 1.5);
  }

  void MeasureTexels() {
    const Eigen::VectorXd areas = FaceAreas(mesh_.points, mesh_.faces);
    area_per_texel_.resize(mesh_.face_count());
    for (int f = 0; f < mesh_.face_count(); ++f) {
      const auto a = mesh_.uvs.row(mesh_.uv_faces(f, 0)), b = mesh_.uvs.row(mesh_.uv_faces(f, 1)), c = mesh_.uvs.row(mesh_.uv_faces(f, 2));
      const double texels = 0.5 * std::abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]) * atlas_.size * atlas_.size;
      area_per_texel_[f] = areas[f] / std::max(texels, 1e-3);
    }
  }

  static bool IsHeldOut(int view, const BakeOptions& options) {
    return options.hold_out > 0 && view % options.hold_out == options.hold_out / 2;
  }

  const Mesh& mesh_;
  const Atlas& atlas_;
  const std::vector<BakeView>& views_;
  const std::vector<Vector3f>& gains_;
  const BakeOptions& options_;
  double least_cosine_;
  PointsX3 face_normals_, vertex_normals_;
  std::vector<std::vector<int>> candidates_;  ///< views that may see a face, ascending
  std::vector<double> sharpness_;             ///< of the views, relative to the median
  std::vector<double> area_per_texel_;        ///< of the faces, in world units squared

 public:
  bool HeldOut(int view) const { return IsHeldOut(view, options_); }
};

std::vector<BakeView> LoadViews(const Mesh& mesh, const RayScene& scene, const std::vector<View>& views,
                                const std::function<Photograph(int)>& load, const BakeOptions& options, std::int64_t texels,
                                Progress* progress) {
  BakeViewOptions view_options;
  view_options.edge_guard_px = options.edge_guard;
  view_options.edge_feather_px = options.edge_feather;
  view_options.texels = 0.5 * static_cast<double>(texels);
  const int count = static_cast<int>(views.size());
  std::vector<std::optional<BakeView>> loaded(count);
  std::mutex mutex;
  int done = 0;
  ParallelFor(count, [&](std::int64_t i) {
    loaded[i].emplace(views[i], load(static_cast<int>(i)), mesh, scene, view_options);
    const std::lock_guard<std::mutex> lock(mutex);
    Step(progress, 0.45 * ++done / count, "photographs and their depth maps");
  });
  std::vector<BakeView> result;
  result.reserve(count);
  for (auto& view : loaded) result.push_back(std::move(*view));
  return result;
}

/// Sums over one row of the atlas.
struct RowCount {
  std::int64_t seen = 0, votes = 0;
  std::vector<char> used;
};

Painting PaintTexels(const Atlas& atlas, const Painter& painter, int view_count, BakeResult& result, Progress* progress) {
  Painting painting;
  painting.color.assign(atlas.face.size(), Vector3f::Zero());
  painting.painted.assign(atlas.face.size(), 0);
  std::vector<RowCount> rows(atlas.size);
  // Bands, so that progress is told and cancelling is possible between them.
  const int band = std::max(16, atlas.size / 16);
  for (int first = 0; first < atlas.size; first += band) {
    Step(progress, 0.5 + 0.35 * first / atlas.size, "texels");
    ParallelFor(std::min(band, atlas.size - first), [&](std::int64_t offset) {
      RowCount& row = rows[first + offset];
      row.used.assign(view_count, 0);
      std::vector<Vote> votes;
      for (int x = 0; x < atlas.size; ++x) {
        const std::size_t texel = static_cast<std::size_t>(first + offset) * atlas.size + x;
        if (atlas.face[texel] < 0) continue;
        painter.CollectVotes(texel, votes);
        if (votes.empty()) continue;
        painting.color[texel] = painter.Color(votes);
        painting.painted[texel] = 1;
        if (!atlas.inside[texel]) continue;
        ++row.seen;
        row.votes += static_cast<std::int64_t>(votes.size());
        for (const Vote& vote : votes) row.used[vote.view] = 1;
      }
    });
  }
  std::int64_t votes = 0;
  for (const RowCount& row : rows) {
    result.seen_texels += row.seen;
    votes += row.votes;
    for (int v = 0; v < view_count; ++v) result.quality[v].used |= row.used[v] != 0;
  }
  result.mean_views_per_texel = result.seen_texels > 0 ? static_cast<double>(votes) / static_cast<double>(result.seen_texels) : 0;
  return painting;
}

}  // namespace

BakeResult Bake(const Mesh& mesh, const std::vector<View>& views, const std::function<Photograph(int)>& load, const BakeOptions& options,
                Progress* progress) {
  RequireUsable(mesh, "bake: mesh");
  if (views.empty()) throw InputError("bake: the model has no views; run sfm again, or pass another --model");
  Step(progress, 0, "atlas");
  const Atlas atlas = RasterizeAtlas(mesh, options.texture_size);
  const RayScene scene(mesh.points, mesh.faces);
  const std::vector<BakeView> loaded = LoadViews(mesh, scene, views, load, options, atlas.texels, progress);
  BakeResult result;
  result.texels = atlas.texels;
  result.quality.resize(views.size());
  Step(progress, 0.45, "gains");
  result.gains = options.harmonize ? HarmonizeGains(mesh, loaded) : std::vector<Vector3f>(views.size(), Vector3f::Ones());
  const Painter painter(mesh, atlas, loaded, result.gains, options);
  Painting painting = PaintTexels(atlas, painter, static_cast<int>(views.size()), result, progress);
  if (result.seen_texels == 0)
    throw InputError("bake: none of the " + std::to_string(views.size()) +
                     " views sees any of the mesh; mesh and model are not in the same frame, " +
                     "the masks are black, or the faces point inwards: pass the mesh and the model of one pose");
  Step(progress, 0.85, "unseen texels and gutters");
  InpaintUnseen(mesh, atlas, painting);
  result.texture = FinishTexture(atlas, painting, options.gutter);
  Step(progress, 0.92, "comparison with the photographs");
  ParallelFor(static_cast<std::int64_t>(views.size()), [&](std::int64_t v) {
    const Comparison comparison = CompareToPhotograph(mesh, scene, result.texture, loaded[v], result.gains[v]);
    ViewQuality& quality = result.quality[v];
    quality.held_out = painter.HeldOut(static_cast<int>(v));
    quality.pixels = comparison.pixels;
    quality.psnr_db = comparison.psnr_db;
    quality.psnr_gain_db = comparison.psnr_gain_db;
  });
  return result;
}

}  // namespace keypose::texture
