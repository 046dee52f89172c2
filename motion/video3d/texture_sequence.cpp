#include "motion/video3d/texture_sequence.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"

namespace keypose::motion {
namespace {

constexpr int kExposureFrames = 8;       // that exposures are compared in
constexpr int kExposureVertices = 2500;  // in each
constexpr int kWrittenAtOnce = 8;

std::vector<FilmedView> ViewsOf(const SequenceInput& input, const FilmedFrame& frame,
                                const FilmedViewOptions& options) {
  std::vector<std::vector<FilmedView>> made(input.views.size());
  ParallelFor(SizeOf(input.views), [&](std::int64_t v) {
    made[v].emplace_back(input.views[v], frame.pictures[v], frame.masks[v], frame.points,
                         input.mesh.faces, options);
  });
  std::vector<FilmedView> views;
  for (std::vector<FilmedView>& one : made) views.push_back(std::move(one.front()));
  return views;
}

CameraExposures ExposureOf(const SequenceInput& input, const SequenceOptions& options) {
  std::vector<ColorPair> pairs;
  const int count = std::min(kExposureFrames, input.frames);
  for (int i = 0; i < count && options.level_exposure; ++i) {
    const int f = static_cast<int>((i + 0.5) * input.frames / count);
    const FilmedFrame frame = input.read(f);
    const std::vector<ColorPair> some = PairsOfViews(
        frame.points, input.mesh.faces, ViewsOf(input, frame, options.view), kExposureVertices);
    pairs.insert(pairs.end(), some.begin(), some.end());
  }
  return LevelExposures(pairs, SizeOf(input.views));
}

/// The colours that the films show, frame by frame, into the store.
void BlendAll(const SequenceInput& input, const SequenceOptions& options,
              const SurfaceTexels& texels, const ColorStore& store, MeanTexture* mean,
              SequenceReport* report, Progress* progress) {
  const std::size_t cameras = input.views.size();
  ViewBlender blender(input.mesh.faces, texels, SizeOf(input.views), options.blend);
  report->covered.assign(cameras, 0);
  report->frames_seen.assign(cameras, 0);
  for (int f = 0; f < input.frames; ++f) {
    ReportProgress(progress, static_cast<double>(f) / input.frames, "blending the films");
    const FilmedFrame frame = input.read(f);
    const std::vector<FilmedView> views = ViewsOf(input, frame, options.view);
    for (std::size_t v = 0; v < cameras; ++v) {
      report->frames_seen[v] += views[v].pixels() > 0;
      report->covered[v] += views[v].pixels() > 0 ? views[v].covered_by_mask() : 0;
    }
    const TexelColors colors = blender.Next(frame.points, views, report->exposure.gains);
    mean->Add(colors);
    store.put(f, colors);
  }
  for (std::size_t v = 0; v < cameras; ++v)
    report->covered[v] /= std::max(1, report->frames_seen[v]);
}

/// The frames within reach of one, read once each.
class Window {
 public:
  Window(const ColorStore& store, int frames, int reach)
      : store_(store), frames_(frames), reach_(reach) {}
  void MoveTo(int frame) {
    colors_.erase(colors_.begin(), colors_.lower_bound(frame - reach_));
    for (int f = std::max(0, frame - reach_); f <= std::min(frames_ - 1, frame + reach_); ++f)
      if (!colors_.count(f)) colors_.emplace(f, store_.get(f));
  }
  const TexelColors* At(int frame) const {
    const auto found = colors_.find(frame);
    return found == colors_.end() ? nullptr : &found->second;
  }

 private:
  const ColorStore& store_;
  int frames_, reach_;
  std::map<int, TexelColors> colors_;
};

void FillAll(const SequenceInput& input, const SequenceOptions& options, TextureFiller* filler,
             const ColorStore& store, const TakeTexture& take, SequenceReport* report,
             Progress* progress) {
  Window window(store, input.frames, options.fill.reach);
  std::vector<Image8> ready;
  for (int f = 0; f < input.frames; ++f) {
    ReportProgress(progress, static_cast<double>(f) / input.frames, "filling what is hidden");
    window.MoveTo(f);
    FilledTexture filled = filler->Fill(f, [&](int frame) { return window.At(frame); });
    report->own.push_back(filled.own);
    report->neighbours.push_back(filled.neighbours);
    ready.push_back(std::move(filled.texture));
    if (SizeOf(ready) < kWrittenAtOnce && f + 1 < input.frames) continue;
    const int first = f + 1 - SizeOf(ready);
    ParallelFor(SizeOf(ready),
                [&](std::int64_t i) { take(first + static_cast<int>(i), ready[i]); });
    ready.clear();
  }
}

}  // namespace

SequenceReport MakeTextures(const SequenceInput& input, const SequenceOptions& options,
                            const ColorStore& store, const TakeTexture& take, Progress* progress) {
  const Atlas atlas = RasterizeAtlas(input.mesh, options.texture_size);
  const SurfaceTexels texels = ListTexels(atlas);
  SequenceReport report;
  ReportProgress(progress, 0, "levelling exposures");
  report.exposure = ExposureOf(input, options);
  MeanTexture mean(texels);
  SubProgress blending(progress, 0.05, 0.6), filling(progress, 0.6, 1);
  BlendAll(input, options, texels, store, &mean, &report, &blending);
  report.seen_ever = mean.seen();
  TextureFiller filler(input.mesh, atlas, texels,
                       mean.Completed(input.mesh, atlas, input.own_texture), options.fill);
  FillAll(input, options, &filler, store, take, &report, &filling);
  return report;
}

int AdviseSequenceSize(const Mesh& mesh, const std::vector<View>& views) {
  std::vector<std::pair<double, double>> sizes;  // wanted size, weight
  double total = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    double pixels = 0;
    for (const View& view : views) {
      Eigen::Vector2d p[3];
      bool before = true;
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d x =
            view.camera_from_world * Eigen::Vector3d(mesh.points.row(mesh.faces(f, k)));
        before &= x.z() > 0;
        if (before) p[k] = view.camera.Project(x);
      }
      if (!before) continue;
      const Eigen::Vector2d a = p[1] - p[0], b = p[2] - p[0];
      pixels =
          std::max(pixels, -0.5 * (a.x() * b.y() - a.y() * b.x()));  // y down: seen from outside
    }
    const Eigen::RowVector2d u = mesh.uvs.row(mesh.uv_faces(f, 1)) -
                                 mesh.uvs.row(mesh.uv_faces(f, 0)),
                             v = mesh.uvs.row(mesh.uv_faces(f, 2)) -
                                 mesh.uvs.row(mesh.uv_faces(f, 0));
    const double area = 0.5 * std::abs(u.x() * v.y() - u.y() * v.x());
    if (area > 0 && pixels > 0) sizes.emplace_back(std::sqrt(pixels / area), pixels);
    total += area > 0 ? pixels : 0;
  }
  std::sort(sizes.begin(), sizes.end());
  double below = 0, wanted = 1024;
  for (const auto& [size, weight] : sizes) {
    wanted = size;
    below += weight;
    if (below >= 0.5 * total) break;
  }
  int size = 256;
  while (size < 2048 && size < 0.9 * wanted) size *= 2;
  return size;
}

}  // namespace keypose::motion
