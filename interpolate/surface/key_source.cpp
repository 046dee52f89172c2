#include "interpolate/surface/key_source.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "deform/poisson/poisson.h"
#include "deform/volume/volume_correction.h"
#include "interpolate/surface/face_paths.h"
#include "interpolate/surface/key_constraints.h"

namespace keypose::interpolation {

namespace {

KeyRefs RefsOf(const std::vector<PointsX3>& keys) { return {keys.begin(), keys.end()}; }

/// Targets of a system's rows: paths of held vertices and regions, then centroids of parts.
class RowPaths {
 public:
  RowPaths(const std::vector<PointsX3>& keys, const PoissonSystem& system, const Schedule& schedule,
           const std::vector<const HeldRegion*>& held)
      : sources_(system.row_sources()) {
    std::vector<const HeldRegion*> region_of_row;
    for (const HeldRegion* region : held)
      region_of_row.insert(region_of_row.end(), region->every_vertex ? region->vertices.size() : 1,
                           region);
    std::vector<RowTargets> at_keys;
    for (const PointsX3& key : keys) at_keys.push_back(system.RowsAt(key));
    rows_.resize(sources_.size());
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      if (sources_[r] < 0) continue;
      std::vector<Eigen::Vector3d> values;
      for (const RowTargets& targets : at_keys) values.emplace_back(targets.row(r));
      rows_[r] =
          SpanSpline<Eigen::Vector3d>(schedule, values, region_of_row[sources_[r]]->waypoints);
    }
  }

  RowTargets At(int span, double way, const FacePaths& paths) const {
    RowTargets targets(std::ssize(rows_), 3);
    for (std::size_t r = 0; r < rows_.size(); ++r)
      targets.row(r) =
          (sources_[r] >= 0 ? rows_[r].At(span, way) : paths.Centroid(span, way, -1 - sources_[r]))
              .transpose();
    return targets;
  }

 private:
  std::vector<int> sources_;
  std::vector<SpanSpline<Eigen::Vector3d>> rows_;
};

/// A system with one set of regions that some spans hold.
struct HeldSystem {
  HeldSystem(const std::vector<PointsX3>& keys, const FacesX3& faces, const Schedule& schedule,
             const std::vector<const HeldRegion*>& held)
      : system(RefsOf(keys), faces, RowsOf(ConstraintsOf(held), static_cast<int>(keys[0].rows()))),
        volume(system),
        rows(keys, system, schedule, held) {}

  static Constraints ConstraintsOf(const std::vector<const HeldRegion*>& held) {
    Constraints constraints;
    for (const HeldRegion* region : held) {
      PatchConstraint patch;
      patch.name = region->name;
      patch.vertices = region->vertices;
      patch.hold = region->every_vertex ? PatchConstraint::Hold::kEveryVertex
                                        : PatchConstraint::Hold::kCentroid;
      constraints.patches.push_back(std::move(patch));
    }
    return constraints;
  }

  PoissonSystem system;
  VolumeCorrection volume;
  RowPaths rows;
};

/// Wanted volumes of closed parts through the keys.
class VolumePaths {
 public:
  VolumePaths() = default;
  VolumePaths(const std::vector<PointsX3>& keys, const VolumeCorrection& volume,
              const Schedule& schedule, const Rules& rules) {
    std::vector<std::vector<double>> at_keys;
    for (const PointsX3& key : keys) at_keys.push_back(volume.Volumes(key));
    for (std::size_t part = 0; part < at_keys[0].size(); ++part) {
      const double sign = at_keys[0][part] > 0 ? 1 : -1;
      const bool one_sign = std::all_of(at_keys.begin(), at_keys.end(),
                                        [&](const auto& v) { return v[part] * sign > 0; });
      signs_.push_back(one_sign ? sign : 0);
      std::vector<double> logs;
      for (const auto& volumes : at_keys)
        logs.push_back(one_sign ? std::log(std::abs(volumes[part])) : 0.0);
      paths_.emplace_back(schedule, logs);
    }
    if (!rules.log_volume.empty())
      ratio_ =
          SpanSpline<double>(schedule, std::vector<double>(keys.size(), 0.0), rules.log_volume);
    has_ratio_ = !rules.log_volume.empty();
  }

  std::vector<double> At(int span, double way) const {
    std::vector<double> targets;
    const double log_ratio = has_ratio_ ? ratio_.At(span, way) : 0;
    for (std::size_t part = 0; part < paths_.size(); ++part)
      targets.push_back(signs_[part] == 0
                            ? std::numeric_limits<double>::quiet_NaN()
                            : signs_[part] * std::exp(paths_[part].At(span, way) + log_ratio));
    return targets;
  }

 private:
  std::vector<double> signs_;  // 0: not corrected
  std::vector<SpanSpline<double>> paths_;
  SpanSpline<double> ratio_;
  bool has_ratio_ = false;
};

}  // namespace

struct KeySource::Impl {
  Impl(const std::vector<PointsX3>& keys_, const FacesX3& faces_, const Schedule& schedule_,
       const Rules& rules_, Stretch stretch)
      : keys(keys_), faces(faces_), schedule(schedule_), rules(rules_) {
    HeldSystem& first = SystemOf(0);
    paths = std::make_unique<FacePaths>(keys, first.system, schedule, rules.turns, stretch);
    volumes = VolumePaths(keys, first.volume, schedule, rules);
    if (!rules.table_height) return;
    for (std::size_t k = 0; k < keys.size(); ++k) {
      lowest.push_back(std::min(*rules.table_height, keys[k].col(2).minCoeff()));
      if (lowest.back() < *rules.table_height)
        notes.push_back("key " + std::to_string(k) + " itself lies " +
                        std::to_string(*rules.table_height - lowest.back()) +
                        " below the table; near it frames may too");
    }
  }

  std::vector<const HeldRegion*> HeldIn(int span) const {
    std::vector<const HeldRegion*> held;
    for (const HeldRegion& region : rules.held)
      if (region.spans[span]) held.push_back(&region);
    return held;
  }

  HeldSystem& SystemOf(int span) {
    const std::vector<const HeldRegion*> held = HeldIn(span);
    std::unique_ptr<HeldSystem>& system = systems[held];
    if (!system) {
      system = std::make_unique<HeldSystem>(keys, faces, schedule, held);
      for (const std::string& row : system->system.dropped_rows())
        notes.push_back("'" + row + "' follows from other held places");
    }
    return *system;
  }

  /// Applies volume and table after the solve.
  std::vector<ComputedFrame> Finish(const HeldSystem& held, int span,
                                    const std::vector<double>& ways,
                                    std::vector<PointsX3> points) const {
    std::vector<ComputedFrame> frames(ways.size());
    const std::vector<PointsX3> directions =
        rules.keep_volume ? held.volume.Directions(RefsOf(points)) : std::vector<PointsX3>();
    ParallelFor(std::ssize(ways), [&](std::int64_t i) {
      frames[i].points = std::move(points[i]);
      if (rules.keep_volume)
        frames[i].volume_move =
            held.volume.Apply(frames[i].points, directions[i], volumes.At(span, ways[i]))
                .largest_move;
      if (rules.table_height) KeepAbove(held, span, ways[i], frames[i]);
    });
    return frames;
  }

  /// Lifting vertices changes the volume, and correcting the volume may push other vertices down. A
  /// few rounds; each also holds the vertices that earlier rounds lifted.
  void KeepAbove(const HeldSystem& held, int span, double way, ComputedFrame& frame) const {
    const Floor table{(1 - way) * lowest[span] + way * lowest[span + 1], {}};
    std::vector<int> held_up;
    for (int round = 0; round < 4; ++round) {
      const std::vector<int> now = held.system.LiftToFloor(frame.points, table);
      std::vector<int> all;
      std::set_union(held_up.begin(), held_up.end(), now.begin(), now.end(),
                     std::back_inserter(all));
      const bool same = all.size() == held_up.size();
      held_up = std::move(all);
      if (same || !rules.keep_volume) break;
      const PointsX3 direction = held.volume.Direction(frame.points);
      const auto result =
          held.volume.Apply(frame.points, direction, volumes.At(span, way), held_up);
      frame.volume_move = std::max(frame.volume_move, result.largest_move);
    }
    const double touching = table.height + 1e-9 * (1 + std::abs(table.height));
    frame.on_table = static_cast<int>((frame.points.col(2).array() <= touching).count());
  }

  std::vector<PointsX3> keys;
  FacesX3 faces;
  Schedule schedule;
  Rules rules;
  std::map<std::vector<const HeldRegion*>, std::unique_ptr<HeldSystem>> systems;
  std::unique_ptr<FacePaths> paths;
  VolumePaths volumes;
  std::vector<double> lowest;  // the table at each key
  std::vector<std::string> notes;
};

KeySource::KeySource(const std::vector<PointsX3>& keys, const FacesX3& faces,
                     const Schedule& schedule, const Rules& rules, Stretch stretch)
    : impl_(std::make_unique<Impl>(keys, faces, schedule, rules, stretch)) {}
KeySource::~KeySource() = default;

std::vector<ComputedFrame> KeySource::At(int span, const std::vector<double>& ways) {
  Impl& s = *impl_;
  HeldSystem& held = s.SystemOf(span);
  EdgeBatch edges(s.faces.rows(), SizeOf(ways));
  s.paths->Evaluate(span, ways, edges);
  std::vector<RowTargets> targets;
  std::vector<Eigen::Matrix3d> turns;
  for (const double way : ways) {
    targets.push_back(held.rows.At(span, way, *s.paths));
    turns.push_back(s.paths->BodyTurn(span, way));
  }
  return s.Finish(held, span, ways, held.system.Solve(edges, targets, turns));
}

SourceReport KeySource::report() const {
  const Impl& s = *impl_;
  SourceReport report;
  report.degenerate_faces = s.paths->degenerate_faces();
  report.notes = s.notes;
  for (std::size_t k = 0; k + 1 < s.keys.size(); ++k) {
    const TurnReport& turns = s.paths->turns(static_cast<int>(k));
    report.largest_turn = std::max(report.largest_turn, turns.largest_turn);
    report.largest_remainder = std::max(report.largest_remainder, turns.largest_remainder);
    report.torn_edges = std::max(report.torn_edges, turns.torn_edges);
    report.loops_that_do_not_close =
        std::max(report.loops_that_do_not_close, turns.loops_that_do_not_close);
    report.differential = report.differential || turns.differential;
  }
  return report;
}

}  // namespace keypose::interpolation
