#include "fit/following/follow.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::fit {
namespace {

constexpr int kBatch = 8;  // frames whose films are in memory at once

using FitOne = std::function<Offsets(int frame, const std::vector<PreparedView>& views)>;

std::vector<Offsets> FitAll(const FollowSource& source, const FitOne& fit, Progress* progress,
                            const char* what) {
  std::vector<Offsets> offsets(static_cast<std::size_t>(source.frames));
  for (int first = 0; first < source.frames; first += kBatch) {
    if (progress && progress->cancelled()) throw Cancelled();
    ReportProgress(progress, static_cast<double>(first) / source.frames, what);
    const int count = std::min(kBatch, source.frames - first);
    const std::vector<std::vector<PreparedView>> views = source.views(first, count);
    ParallelFor(count, [&](std::int64_t i) {
      const int f = first + static_cast<int>(i);
      offsets[f] = fit(f, views[i]);
    });
  }
  return offsets;
}

}  // namespace

std::vector<Offsets> FollowFilms(const FollowedMesh& mesh, const FollowSource& source,
                                 const SurfaceTexture* texture, const FollowOptions& options,
                                 Progress* progress) {
  SubProgress first(progress, 0, 0.7), second(progress, 0.7, 1);
  const std::vector<Offsets> rough = FitAll(
      source,
      [&](int f, const std::vector<PreparedView>& views) {
        return FitFrame(mesh, source.base(f), views, texture, {}, options.fit);
      },
      &first, "bending");
  const PointsX3 shape = MeanOffsets(rough);
  // Wider means for the start of the second pass: there is less to lose yet.
  const std::vector<Offsets> starts = Calmed(rough, 2 * options.calm_frames);
  const std::vector<Offsets> bent = FitAll(
      source,
      [&](int f, const std::vector<PreparedView>& views) {
        return FitFrame(mesh, source.base(f), views, texture, {&shape, &starts[f].local},
                        options.fit);
      },
      &second, "bending, calmer");
  return Calmed(bent, options.calm_frames);
}

FollowedFrames::FollowedFrames(const FollowedMesh& mesh, const FollowSource& source,
                               const std::vector<Offsets>& offsets, bool keep_volume)
    : mesh_(mesh), source_(source), offsets_(offsets) {
  if (!keep_volume) return;
  const PointsX3 first = source.base(0);
  system_.emplace(KeyRefs{first}, mesh.faces());
  correction_.emplace(*system_);
  std::vector<std::vector<double>> before(offsets.size()), after(offsets.size());
  ParallelFor(SizeOf(offsets), [&](std::int64_t f) {
    const PointsX3 base = source.base(static_cast<int>(f));
    before[f] = correction_->Volumes(base);
    after[f] = correction_->Volumes(Bent(mesh, base, offsets[f].local).points);
  });
  const std::size_t parts = correction_->closed_parts().size();
  double all_before = 0, all_after = 0;
  for (std::size_t p = 0; p < parts; ++p) {
    double sum_before = 0, sum_after = 0;
    for (std::size_t f = 0; f < offsets.size(); ++f) {
      sum_before += before[f][p];
      sum_after += after[f][p];
    }
    const double growth = sum_after / sum_before;
    growth_.push_back(
        growth > 0 && std::isfinite(growth) ? growth : std::numeric_limits<double>::quiet_NaN());
    all_before += sum_before;
    all_after += sum_after;
  }
  if (all_before > 0) ratio_ = all_after / all_before;
}

std::vector<double> FollowedFrames::Targets(const PointsX3& base) const {
  std::vector<double> targets = correction_->Volumes(base);
  for (std::size_t p = 0; p < targets.size(); ++p) targets[p] *= growth_[p];
  return targets;
}

BentFrame FollowedFrames::At(int frame) const {
  const PointsX3 base = source_.base(frame);
  BentFrame bent = Bent(mesh_, base, offsets_[frame].local);
  if (correction_)
    correction_->Apply(bent.points, correction_->Direction(bent.points), Targets(base));
  return bent;
}

double Flicker(const PointsX3& before, const PointsX3& now, const PointsX3& after) {
  return (before - 2 * now + after).rowwise().norm().mean();
}

}  // namespace keypose::fit
