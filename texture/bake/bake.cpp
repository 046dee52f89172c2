#include "texture/bake/bake.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "texture/bake/face_split.h"
#include "texture/bake/gain.h"
#include "texture/bake/paint.h"
#include "texture/bake/texture_quality.h"
#include "views/atlas/atlas.h"

namespace keypose::texture {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// With fewer photographs, none is held out.
constexpr int kLeastForHoldOut = 12;
/// Tuned on held-out photographs of the synthetic character, the plush dog and the skull: best of
/// 0.03 to 20 (docs/algorithms/bake.md).
struct CommonLightTuning {
  /// weight of the mean of all views, in squared jumps between views; small, so that the mean
  /// determines colours over several rings of faces, and detail stays
  KEYPOSE_TUNED(double, kToMean, 0.03);
};
/// Size of the texture that predicts held-out photographs.
constexpr int kMeasureSize = 1024;

std::vector<BakeView> LoadViews(const Mesh& mesh, const std::vector<View>& views,
                                const std::function<Photograph(int)>& load,
                                const BakeOptions& options, std::int64_t texels,
                                Progress* progress) {
  const RayScene scene(mesh.points, mesh.faces);
  BakeViewOptions view_options;
  view_options.edge_guard_px = options.edge_guard;
  view_options.edge_feather_px = options.edge_feather;
  view_options.texels = 0.5 * static_cast<double>(texels);
  const int count = SizeOf(views);
  std::vector<std::optional<BakeView>> loaded(count);
  std::mutex mutex;
  int done = 0;
  ParallelFor(count, [&](std::int64_t i) {
    loaded[i].emplace(views[i], load(static_cast<int>(i)), mesh, scene, view_options);
    const std::lock_guard<std::mutex> lock(mutex);
    ReportProgress(progress, static_cast<double>(++done) / count,
                   "photographs and their depth maps");
  });
  std::vector<BakeView> result;
  result.reserve(count);
  for (auto& view : loaded) result.push_back(std::move(*view));
  return result;
}

/// The data that the final texture and the one for measurements share.
struct Studio {
  const Mesh& mesh;
  const std::vector<BakeView>& views;
  const BakeOptions& options;
};

struct Baked {
  ImageF linear;
  Image8 texture, confidence;
  std::vector<Vector3f> gains;
  PaintResult paint;
};

Baked BakeFrom(const Studio& studio, const Atlas& atlas, const std::vector<char>& used,
               Progress* progress) {
  Baked baked;
  ReportProgress(progress, 0, "gains");
  baked.gains = studio.options.harmonize
                    ? HarmonizeGains(studio.mesh, studio.views, used)
                    : std::vector<Vector3f>(studio.views.size(), Vector3f::Ones());
  AlignOptions align;
  align.samples =
      static_cast<int>(std::clamp<std::int64_t>(atlas.texels / 16, 2000, align.samples));
  const std::vector<Warp> warps = studio.options.align
                                      ? AlignPhotographs(studio.mesh, studio.views, used, align)
                                      : std::vector<Warp>();
  const ColorSampler sampler(studio.mesh, studio.views, baked.gains, warps, used, atlas.size,
                             studio.options.max_angle, studio.options.strictness);
  SubProgress painting(progress, 0.1, 0.8);
  PaintOptions paint;
  paint.to_mean = studio.options.common_light ? CommonLightTuning::kToMean : 0;
  paint.detail_step = studio.options.common_light ? static_cast<float>(studio.options.detail_step)
                                                  : std::numeric_limits<float>::infinity();
  baked.paint = PaintTexels(sampler, atlas, paint, &painting);
  if (baked.paint.seen_texels == 0) return baked;
  ReportProgress(progress, 0.8, "unseen texels and gutters");
  baked.confidence = Image8(atlas.size, atlas.size, 1);
  baked.confidence.data = baked.paint.painting.sure;
  InpaintUnseen(studio.mesh, atlas, baked.paint.painting);
  baked.linear = FinishTexture(atlas, std::move(baked.paint.painting), studio.options.gutter);
  baked.texture = SrgbImage(baked.linear);
  return baked;
}

/// Removes photographs, or parts of them, with outlier colours.
/// @return one per view; default values if `consensus` is off
std::vector<ViewColors> Consent(const Mesh& mesh, const BakeOptions& options,
                                std::vector<char>& used, std::vector<BakeView>& views) {
  if (!options.consensus) return std::vector<ViewColors>(views.size());
  const std::vector<Vector3f> gains = options.harmonize
                                          ? HarmonizeGains(mesh, views, used)
                                          : std::vector<Vector3f>(views.size(), Vector3f::Ones());
  std::vector<ViewColors> colors = JudgeColors(mesh, views, gains, used);
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (colors[v].distrusted) used[v] = 0;
    if (colors[v].other_light)
      views[v].Weigh(static_cast<float>(ConsensusTuning::kOtherLightWeight));
    if (!colors[v].hidden.empty()) views[v].Hide(colors[v].hidden, colors[v].block_px);
  }
  return colors;
}

std::vector<Comparison> Compare(const Studio& studio, const Image8& texture,
                                const std::vector<char>& which) {
  const TextureLevels levels(texture);
  std::vector<Comparison> comparisons(studio.views.size());
  ParallelFor(std::ssize(studio.views), [&](std::int64_t v) {
    if (which[v])
      comparisons[v] = CompareToPhotograph(studio.mesh, levels, texture.width, studio.views[v]);
  });
  return comparisons;
}

/// 1 for the held-out photographs; none if there are too few.
std::vector<char> HeldOut(const std::vector<BakeView>& views, const std::vector<char>& trusted,
                          int period) {
  std::vector<char> held_out(views.size(), 0);
  int seeing = 0;
  for (const BakeView& view : views) seeing += !view.sees_nothing();
  if (period < 2 || seeing < kLeastForHoldOut) return held_out;
  for (std::size_t v = 0; v < views.size(); ++v)
    held_out[v] =
        static_cast<int>(v) % period == period / 2 && !views[v].sees_nothing() && trusted[v];
  return held_out;
}

void SetHeldOut(const std::vector<Comparison>& comparisons, const std::vector<char>& held_out,
                BakeResult& result) {
  for (std::size_t v = 0; v < comparisons.size(); ++v) {
    ViewQuality& quality = result.quality[v];
    quality.held_out = held_out[v] && comparisons[v].pixels > 0;
    if (!quality.held_out) continue;
    quality.held_out_psnr_db = comparisons[v].psnr_db;
    quality.held_out_psnr_gain_db = comparisons[v].psnr_gain_db;
    quality.held_out_ssim = comparisons[v].ssim;
  }
}

void MeasurePrediction(const Studio& studio, const Atlas& atlas, const std::vector<char>& trusted,
                       const std::vector<char>& held_out, BakeResult& result, Progress* progress) {
  std::vector<char> rest(held_out.size());
  for (std::size_t v = 0; v < rest.size(); ++v) rest[v] = trusted[v] && !held_out[v];
  std::optional<Atlas> small;
  if (atlas.size > kMeasureSize) small.emplace(RasterizeAtlas(studio.mesh, kMeasureSize));
  const Baked baked = BakeFrom(studio, small ? *small : atlas, rest, progress);
  if (baked.paint.seen_texels > 0)
    SetHeldOut(Compare(studio, baked.texture, held_out), held_out, result);
}

}  // namespace

std::vector<std::string> BakeOptions::Problems() const {
  std::vector<std::string> problems;
  if (texture_size > 0 && texture_size < 16)
    problems.push_back("texture_size is " + std::to_string(texture_size) +
                       ", but must be 0 or at least 16");
  if (bits != 0 && bits != 8 && bits != 16 && bits != 32)
    problems.push_back("bits is " + std::to_string(bits) + ", but must be 0, 8, 16 or 32");
  if (hold_out == 1)
    problems.push_back(
        "hold_out is 1, which would leave no photograph: it must be 0 or at least 2");
  return problems;
}

int AdviseTextureSize(const Mesh& mesh, const std::vector<View>& views) {
  const Eigen::VectorXd areas = FaceAreas(mesh.points, mesh.faces),
                        scale = PixelsPerUnit(mesh, views);
  std::vector<std::pair<double, double>> sizes;  // wanted, area
  for (int f = 0; f < mesh.face_count(); ++f) {
    const auto a = mesh.uvs.row(mesh.uv_faces(f, 0)), b = mesh.uvs.row(mesh.uv_faces(f, 1)),
               c = mesh.uvs.row(mesh.uv_faces(f, 2));
    const double uv_area = 0.5 * std::abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]);
    if (uv_area > 0 && areas[f] > 0 && scale[f] > 0)
      sizes.emplace_back(std::sqrt(areas[f] / uv_area) * scale[f], areas[f]);
  }
  std::sort(sizes.begin(), sizes.end());
  double total = 0, below = 0, wanted = 0;
  for (const auto& size : sizes) total += size.second;
  for (const auto& size : sizes) {
    wanted = size.first;
    if ((below += size.second) >= total / 2) break;
  }
  int size = 256;
  while (size < 4096 && 1.1 * size < wanted) size *= 2;
  return size;
}

namespace {

/// How well each photograph is shown again.
void SetQuality(const std::vector<Comparison>& comparisons, const std::vector<char>& used,
                BakeResult& result) {
  for (std::size_t v = 0; v < comparisons.size(); ++v) {
    ViewQuality& quality = result.quality[v];
    quality.used = used[v];
    quality.pixels = comparisons[v].pixels;
    quality.psnr_db = comparisons[v].psnr_db;
    quality.psnr_gain_db = comparisons[v].psnr_gain_db;
    quality.ssim = comparisons[v].ssim;
  }
}

}  // namespace

BakeResult Bake(const Mesh& given, const std::vector<View>& views,
                const std::function<Photograph(int)>& load, const BakeOptions& options,
                Progress* progress) {
  RequireUsable(given, "bake: mesh");
  if (views.empty())
    throw InputError("bake: the model has no views; run sfm again, or pass another --model");
  ReportProgress(progress, 0, "atlas");
  BakeResult result;
  result.quality.resize(views.size());
  CheckUvs(given);
  result.advised_size = AdviseTextureSize(given, views);
  const Mesh mesh = SplitLargeFaces(given, views);
  const Atlas atlas =
      RasterizeAtlas(mesh, options.texture_size > 0 ? options.texture_size : result.advised_size);
  result.texels = atlas.texels;
  SubProgress loading(progress, 0.02, 0.4), painting(progress, 0.4, 0.8),
      measuring(progress, 0.85, 1);
  std::vector<BakeView> loaded = LoadViews(mesh, views, load, options, atlas.texels, &loading);
  std::vector<char> trusted(views.size(), 1);
  result.colors = Consent(mesh, options, trusted, loaded);
  const Studio studio{mesh, loaded, options};
  const std::vector<char> held_out = HeldOut(loaded, trusted, options.hold_out);
  std::vector<char> used = trusted;
  for (std::size_t v = 0; v < used.size(); ++v)
    used[v] = trusted[v] && !(options.leave_out && held_out[v]);
  Baked baked = BakeFrom(studio, atlas, used, &painting);
  result.seen_texels = baked.paint.seen_texels;
  if (result.seen_texels == 0)
    throw InputError(
        "bake: none of the " + std::to_string(views.size()) +
        " views sees any of the mesh; mesh and model are not in the same frame, " +
        "the masks are black, or the faces point inwards: pass the mesh and the model of one pose");
  ReportProgress(progress, 0.8, "comparison with the photographs");
  const std::vector<Comparison> comparisons = Compare(studio, baked.texture, trusted);
  SetQuality(comparisons, baked.paint.used, result);
  if (options.leave_out)
    SetHeldOut(comparisons, held_out, result);
  else if (std::count(held_out.begin(), held_out.end(), 1) > 0)
    MeasurePrediction(studio, atlas, trusted, held_out, result, &measuring);
  result.mean_views_per_texel = baked.paint.mean_views;
  result.gains = std::move(baked.gains);
  result.linear = std::move(baked.linear);
  result.texture = std::move(baked.texture);
  result.confidence = std::move(baked.confidence);
  return result;
}

}  // namespace keypose::texture
