#include "interpolate/sequence.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/camera.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "interpolate/surface/arap.h"
#include "interpolate/surface/key_source.h"
#include "interpolate/surface/paper_arap.h"
#include "interpolate/volume/volumetric.h"

namespace keypose::interpolation {

namespace {

/// The least-squares rotation about z and horizontal translation. Heights stay: in each key the
/// ground is at z = 0.
Similarity3 FitUpright(const PointsX3& a, const PointsX3& b) {
  const Eigen::RowVector3d ca = a.colwise().mean(), cb = b.colwise().mean();
  double dot = 0, cross = 0;
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    const Eigen::RowVector3d x = a.row(i) - ca, y = b.row(i) - cb;
    dot += x[0] * y[0] + x[1] * y[1];
    cross += x[0] * y[1] - x[1] * y[0];
  }
  Similarity3 s;
  s.rotation =
      Eigen::AngleAxisd(std::atan2(cross, dot), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  s.translation = cb.transpose() - s.rotation * ca.transpose();
  s.translation.z() = 0;
  return s;
}

void CheckKeys(const std::vector<PointsX3>& keys, const FacesX3& faces, const Schedule& schedule) {
  if (keys.size() < 2) throw InputError("interpolate: needs at least two keys");
  if (schedule.spans.size() + 1 != keys.size())
    throw InputError("interpolate: the schedule is one of another number of keys");
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (keys[k].rows() != keys[0].rows())
      throw InputError("interpolate: key " + std::to_string(k) + " has " +
                       std::to_string(keys[k].rows()) + " vertices, the first has " +
                       std::to_string(keys[0].rows()) +
                       "; register all poses from one template first");
    Mesh mesh;
    mesh.points = keys[k];
    mesh.faces = faces;
    RequireUsable(mesh, "interpolate: key " + std::to_string(k));
  }
  if (schedule.loop && keys.front() != keys.back())
    throw InputError(
        "interpolate: the timeline loops, but its last key is another pose than its first; end it "
        "with the first pose again, at "
        "the time when the loop closes");
}

/// A source for methods that use two keys at a time. It holds only the current span's interpolator.
template <class Interpolator>
class PairSource : public FrameSource {
 public:
  PairSource(std::vector<PointsX3> keys, FacesX3 faces)
      : keys_(std::move(keys)), faces_(std::move(faces)) {}

  std::vector<ComputedFrame> At(int span, const std::vector<double>& ways) override {
    if (span != span_) {
      current_.reset();
      current_.emplace(Make(keys_[span], keys_[span + 1], faces_));
      span_ = span;
      Gather(*current_, report_);
    }
    return Compute(*current_, ways);
  }
  SourceReport report() const override { return report_; }

 protected:
  virtual Interpolator Make(const PointsX3& v, const PointsX3& u, const FacesX3& faces) const = 0;
  virtual std::vector<ComputedFrame> Compute(const Interpolator& interpolator,
                                             const std::vector<double>& ways) const = 0;
  virtual void Gather(const Interpolator&, SourceReport&) const {}

 private:
  std::vector<PointsX3> keys_;
  FacesX3 faces_;
  std::optional<Interpolator> current_;
  int span_ = -1;
  SourceReport report_;
};

struct StraightLines {
  PointsX3 v, u;
};

class LinearSource final : public PairSource<StraightLines> {
 public:
  using PairSource::PairSource;

 protected:
  StraightLines Make(const PointsX3& v, const PointsX3& u, const FacesX3&) const override {
    return {v, u};
  }
  std::vector<ComputedFrame> Compute(const StraightLines& lines,
                                     const std::vector<double>& ways) const override {
    std::vector<ComputedFrame> frames;
    for (const double way : ways)
      frames.push_back({InterpolateLinearly(lines.v, lines.u, way), 0, 0});
    return frames;
  }
};

/// Two keys and no rules but the volume: the fast path.
class ArapPairSource final : public PairSource<ArapInterpolator> {
 public:
  ArapPairSource(const std::vector<PointsX3>& keys, const FacesX3& faces, const Rules& rules)
      : PairSource(keys, faces) {
    options_.correct_volume = rules.keep_volume;
    options_.turn_overrides = rules.turns.front();
  }

 protected:
  ArapInterpolator Make(const PointsX3& v, const PointsX3& u, const FacesX3& faces) const override {
    return {v, u, faces, options_};
  }
  std::vector<ComputedFrame> Compute(const ArapInterpolator& arap,
                                     const std::vector<double>& ways) const override {
    std::vector<FrameFacts> facts;
    std::vector<PointsX3> points = arap.At(ways, &facts);
    std::vector<ComputedFrame> frames;
    for (std::size_t i = 0; i < ways.size(); ++i)
      frames.push_back({std::move(points[i]), facts[i].volume_move, 0});
    return frames;
  }
  void Gather(const ArapInterpolator& arap, SourceReport& report) const override {
    const ArapReport& one = arap.report();
    report.degenerate_faces = one.degenerate_faces;
    report.largest_turn = one.turns.largest_turn;
    report.largest_remainder = one.turns.largest_remainder;
    report.torn_edges = one.turns.torn_edges;
    report.loops_that_do_not_close = one.turns.loops_that_do_not_close;
    report.differential = one.turns.differential;
  }

 private:
  ArapOptions options_;
};

class PaperSource final : public PairSource<PaperInterpolator> {
 public:
  using PairSource::PairSource;

 protected:
  PaperInterpolator Make(const PointsX3& v, const PointsX3& u,
                         const FacesX3& faces) const override {
    return {v, u, faces};
  }
  std::vector<ComputedFrame> Compute(const PaperInterpolator& paper,
                                     const std::vector<double>& ways) const override {
    std::vector<ComputedFrame> frames;
    for (const double way : ways) frames.push_back({paper.At(way), 0, 0});
    return frames;
  }
};

class VolumetricSource final : public PairSource<VolumetricInterpolator> {
 public:
  VolumetricSource(const std::vector<PointsX3>& keys, const FacesX3& faces, bool keep_volume)
      : PairSource(keys, faces), keep_volume_(keep_volume) {}

 protected:
  VolumetricInterpolator Make(const PointsX3& v, const PointsX3& u,
                              const FacesX3& faces) const override {
    VolumetricOptions options;
    options.keep_volume = keep_volume_;
    return {v, u, faces, options};
  }
  std::vector<ComputedFrame> Compute(const VolumetricInterpolator& solid,
                                     const std::vector<double>& ways) const override {
    std::vector<ComputedFrame> frames;
    for (PointsX3& points : solid.At(ways)) frames.push_back({std::move(points), 0, 0});
    return frames;
  }
  void Gather(const VolumetricInterpolator& solid, SourceReport& report) const override {
    const VolumetricReport& one = solid.report();
    report.tetrahedra = std::max(report.tetrahedra, one.tetrahedra);
    report.largest_turn = std::max(report.largest_turn, one.largest_turn);
    report.largest_tear = std::max(report.largest_tear, one.largest_tear);
    if (!one.note.empty()) report.notes.push_back(one.note);
  }

 private:
  bool keep_volume_;
};

/// Frames of one span that are computed together: from `first` on, without keys and repeated
/// frames.
std::vector<int> NextBatch(const Schedule& schedule, int first, int most) {
  std::vector<int> batch;
  const int span = schedule.frames[first].span;
  for (int f = first; f < std::ssize(schedule.frames) && SizeOf(batch) < most; ++f) {
    const PlannedFrame& frame = schedule.frames[f];
    if (frame.span != span || (frame.key >= 0 && f > first)) break;
    if (frame.key < 0 && frame.same_as < 0) batch.push_back(f);
  }
  return batch;
}

/// About 100 MiB of right-hand sides and results. More than 16 frames do not make a solve faster
/// per frame.
int BatchSize(Eigen::Index vertices) {
  return static_cast<int>(
      std::clamp<Eigen::Index>(2'000'000 / std::max<Eigen::Index>(vertices, 1), 1, 16));
}

}  // namespace

std::vector<PointsX3> AlignedKeys(const std::vector<PointsX3>& keys, AlignKeys align) {
  std::vector<PointsX3> aligned = keys;
  for (std::size_t k = 1; k < keys.size() && align != AlignKeys::kNone; ++k) {
    // A repeated pose gets the same bits as before, so that a hold does not move and loops can
    // close.
    const auto before =
        std::find(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(k), keys[k]);
    if (before - keys.begin() < static_cast<std::ptrdiff_t>(k))
      aligned[k] = aligned[before - keys.begin()];
    else if (keys[k].rows() == keys[0].rows())
      aligned[k] =
          Transformed(align == AlignKeys::kUpright
                          ? FitUpright(keys[k], keys[0])
                          : FitSimilarity(keys[k], keys[0], {}, align == AlignKeys::kSimilarity),
                      keys[k]);
  }
  return aligned;
}

std::vector<double> RelativeSizes(const std::vector<PointsX3>& keys, const FacesX3& faces) {
  std::vector<double> sizes(keys.size(), 1);
  const auto edges = UndirectedEdges(faces);
  for (std::size_t k = 1; k < keys.size(); ++k) {
    std::vector<double> ratios;
    for (const auto& [i, j] : edges)
      if (const double length = (keys[0].row(i) - keys[0].row(j)).norm(); length > 0)
        ratios.push_back((keys[k].row(i) - keys[k].row(j)).norm() / length);
    if (ratios.empty()) continue;
    const double middle = UpperMedian(std::move(ratios));
    if (middle > 0) sizes[k] = middle;
  }
  return sizes;
}

std::vector<PointsX3> SameSized(const std::vector<PointsX3>& keys, const FacesX3& faces) {
  std::vector<PointsX3> sized = keys;
  const std::vector<double> sizes = RelativeSizes(keys, faces);
  for (std::size_t k = 1; k < keys.size(); ++k) sized[k] = keys[k] / sizes[k];
  return sized;
}

std::unique_ptr<FrameSource> MakeFrameSource(const std::vector<PointsX3>& keys,
                                             const FacesX3& faces, const Schedule& schedule,
                                             Method method, const Rules& rules) {
  CheckKeys(keys, faces, schedule);
  switch (method) {
    case Method::kPaper:
      return std::make_unique<PaperSource>(keys, faces);
    case Method::kLinear:
      return std::make_unique<LinearSource>(keys, faces);
    case Method::kVolumetric:
      return std::make_unique<VolumetricSource>(keys, faces, rules.keep_volume);
    default:
      if (keys.size() == 2 && !AnySmooth(schedule) && rules.held.empty() && !rules.table_height &&
          rules.log_volume.empty())
        return std::make_unique<ArapPairSource>(keys, faces, rules);
      return std::make_unique<KeySource>(keys, faces, schedule, rules);
  }
}

void StreamFrames(const std::vector<PointsX3>& keys, const Schedule& schedule, FrameSource& source,
                  const std::function<void(const FrameView&)>& take, Progress* progress) {
  const int count = SizeOf(schedule.frames), most = BatchSize(keys[0].rows());
  std::vector<ComputedFrame> batch;  // frames that `take` has not had yet, last first
  ComputedFrame shown;               // the frame that repeated frames copy
  for (int f = 0; f < count; ++f) {
    const PlannedFrame& plan = schedule.frames[f];
    if (plan.same_as < 0) {
      ReportProgress(progress, static_cast<double>(f) / count, "frames between keys");
      if (plan.key >= 0) {
        shown = {keys[plan.key], 0, 0};
      } else {
        if (batch.empty()) {
          const std::vector<int> next = NextBatch(schedule, f, most);
          std::vector<double> ways;
          for (const int i : next) ways.push_back(schedule.frames[i].way);
          batch = source.At(plan.span, ways);
          std::reverse(batch.begin(), batch.end());
        }
        shown = std::move(batch.back());
        batch.pop_back();
        if (!shown.points.allFinite())
          throw SolverError("interpolate: frame " + std::to_string(f) + ", between keys " +
                            std::to_string(plan.span) + " and " + std::to_string(plan.span + 1) +
                            ", is not finite");
      }
    }
    take({f, plan, shown.points, shown.volume_move, shown.on_table});
  }
}

}  // namespace keypose::interpolation
