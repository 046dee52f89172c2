#include "interpolate/surface/arap.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "deform/volume/volume_correction.h"
#include "interpolate/maps/face_crossings.h"
#include "interpolate/maps/key_pair.h"
#include "interpolate/surface/loose_parts.h"
#include "interpolate/surface/pair_paths.h"
#include "interpolate/surface/row_frames.h"
#include "interpolate/turns/differential_turns.h"
#include "interpolate/turns/turning_field.h"

namespace keypose::interpolation {

namespace {

// Chosen on the bends and twists with known answers (docs/results/interpolation.md); sensitivity:
// docs/results/sensitivity.md.
struct GrowthTuning {
  // passes over the screening length each, so that a region wider than a limb counts, and a bend's
  // inside and outside cancel
  KEYPOSE_TUNED(int, kGrowthPasses, 4);
};

// No record of the data; sensitivity: docs/results/sensitivity.md.
struct VolumeStepTuning {
  // of the diagonal: frames with larger steps to the wanted volume are computed singly
  KEYPOSE_TUNED(double, kNearStep, 0.05);
};

// of the diagonal: constraints that move a key by less leave it as it is
constexpr double kAtKey = 1e-12;

/// Whether `a` comes first in the order that decides from which key the computation starts.
bool Before(const PointsX3& a, const PointsX3& b) {
  return !std::lexicographical_compare(b.data(), b.data() + b.size(), a.data(),
                                       a.data() + a.size());
}

KeyRefs EnergyKeys(const PointsX3& v, const PointsX3& u, bool symmetric) {
  return symmetric ? KeyRefs{v, u} : KeyRefs{v};
}

}  // namespace

CentroidPaths::CentroidPaths(const PointsX3& v, const PointsX3& u, const std::vector<int>& parts,
                             int part_count, const Eigen::Vector3d& body_turn)
    : start_(PointsX3::Zero(part_count, 3)),
      end_(PointsX3::Zero(part_count, 3)),
      body_turn_(body_turn) {
  Eigen::VectorXd count = Eigen::VectorXd::Zero(part_count);
  for (Eigen::Index i = 0; i < v.rows(); ++i) {
    count[parts[i]] += 1;
    start_.row(parts[i]) += v.row(i);
    end_.row(parts[i]) += u.row(i);
  }
  body_start_ = v.colwise().mean();
  body_end_ = u.colwise().mean();
  const Eigen::Matrix3d body = ExpOf(body_turn);
  for (int p = 0; p < part_count; ++p) {
    start_.row(p) = start_.row(p) / count[p] - body_start_.transpose();
    end_.row(p) = (end_.row(p) / count[p] - body_end_.transpose()) * body;
  }
}

Eigen::Vector3d CentroidPaths::At(int part, double t) const {
  return (1 - t) * body_start_ + t * body_end_ +
         ExpOf(t * body_turn_) * ((1 - t) * start_.row(part) + t * end_.row(part)).transpose();
}

ArapOptions PaperOptions() {
  ArapOptions options;
  options.symmetric = false;
  options.stretch = Stretch::kLinear;
  options.follow_turns = false;
  options.correct_volume = false;
  return options;
}

void SetGrowth(const PoissonSystem& system, SegmentMaps& maps) {
  Eigen::MatrixXd growth(maps.faces.size(), 1);
  for (Eigen::Index f = 0; f < growth.rows(); ++f)
    growth(f, 0) =
        maps.faces[f].degenerate ? 0.0 : 0.5 * std::log(maps.faces[f].stretch.determinant());
  const Eigen::MatrixXd smooth = system.SmoothOverVertices(growth, GrowthTuning::kGrowthPasses);
  const FacesX3& faces = system.faces();
  for (Eigen::Index f = 0; f < growth.rows(); ++f)
    maps.faces[f].growth =
        (smooth(faces(f, 0), 0) + smooth(faces(f, 1), 0) + smooth(faces(f, 2), 0)) / 3;
}

struct ArapInterpolator::Impl {
  Impl(const PointsX3& first, const PointsX3& second, const FacesX3& faces, const ArapOptions& o)
      : options(o),
        // Everything is computed from one key to the other in an order that depends on the keys
        // alone, so that swapped keys give the same bits.
        reversed(o.symmetric && !Before(first, second)),
        v(reversed ? second : first),
        u(reversed ? first : second),
        system(
            EnergyKeys(v, u, o.symmetric), faces,
            RowsOf(o.constraints, static_cast<int>(first.rows())),
            {.screened = o.correct_volume || o.follow_turns || o.stretch == Stretch::kBalanced}) {
    maps = FaceMapsOf(v, u, faces);
    if (options.follow_turns)
      report.turns = FollowTurns(system, maps, options.turn_overrides, reversed);
    else
      ShortestTurns(maps);
    if (options.stretch == Stretch::kBalanced) SetGrowth(system, maps);
    if (report.turns.differential) differential.emplace(system, maps);
    paths.emplace(v, u, system.faces(), maps, options.stretch);
    centroids.emplace(v, u, system.parts(), system.part_count(), maps.body_turn);
    loose_parts.emplace(system, v, u, maps);
    report.riding_parts = loose_parts->riding();
    if (options.correct_volume) PrepareVolumes();
    if (system.IsFree() && !options.constraints.floor && !differential && (!volumes || outward))
      together.emplace(system, outward ? &*outward : nullptr);
    Describe();
  }

  void PrepareVolumes() {
    volumes.emplace(system);
    v_volumes = volumes->Volumes(v);
    u_volumes = volumes->Volumes(u);
    for (double target : PathVolumes(v_volumes, u_volumes, 0.5))
      report.corrected_parts += std::isfinite(target);
    if (report.corrected_parts == 0) return volumes.reset();
    if (report.turns.differential || maps.vertex_turns.rows() == 0)
      return;  // directions are then solved for each frame
    // The outward fields of both keys. Between the keys each vertex blends them, turned with its
    // surroundings.
    const std::vector<PointsX3> z = volumes->Directions({v, u});
    outward.emplace(maps, z[0], z[1]);
  }

  void Describe() {
    report.degenerate_faces = static_cast<int>(std::count_if(
        maps.faces.begin(), maps.faces.end(), [](const FaceMap& m) { return m.degenerate; }));
    if (!options.follow_turns)
      for (const FaceMap& m : maps.faces)
        report.turns.largest_turn = std::max(report.turns.largest_turn, m.turn.norm());
    if (volumes)
      report.closed_parts = static_cast<int>(
          std::count(volumes->closed_parts().begin(), volumes->closed_parts().end(), 1));
    report.dropped_constraints = system.dropped_rows();
  }

  /// Targets of the rows in use at time t, where t runs in the order of computation.
  RowTargets Targets(double t) const {
    // Paths are functions of the time of the caller.
    const RowTargets given = reversed ? TargetsOf(options.constraints, u, v, 1 - t)
                                      : TargetsOf(options.constraints, v, u, t);
    RowTargets targets(std::ssize(system.rows()), 3);
    for (Eigen::Index r = 0; r < targets.rows(); ++r) {
      const int source = system.row_sources()[r];
      targets.row(r) =
          source >= 0 ? given.row(source).transpose().eval() : centroids->At(-1 - source, t);
    }
    return targets;
  }

  /// Frames before volume and floor. With relative rotations only a few frames are computed at a
  /// time.
  std::vector<PointsX3> OneByOne(const std::vector<double>& times) const {
    std::vector<PointsX3> frames;
    const std::size_t together_at_most = differential ? 4 : times.size();
    for (std::size_t begin = 0; begin < times.size(); begin += together_at_most) {
      const std::size_t end = std::min(times.size(), begin + together_at_most);
      std::vector<RowTargets> targets;
      std::vector<Eigen::Matrix3d> turns;
      std::vector<std::vector<Eigen::Matrix3d>> rotations;
      for (std::size_t k = begin; k < end; ++k) {
        targets.push_back(Targets(times[k]));
        turns.push_back(ExpOf(times[k] * maps.body_turn));
        if (differential) rotations.push_back(differential->At(times[k]));
      }
      const auto fill = [&](int first, EdgeBatch& edges) {
        const auto from = times.begin() + static_cast<std::ptrdiff_t>(begin) + first;
        if (!differential) return paths->Evaluate({from, from + edges.frames}, edges);
        for (int k = 0; k < edges.frames; ++k)
          paths->EvaluateWith(rotations[first + k], from[k], k, edges);
      };
      for (PointsX3& frame : system.Solve(static_cast<int>(end - begin), fill, targets, turns))
        frames.push_back(std::move(frame));
    }
    return frames;
  }

  bool IsKey(double t) const {
    if ((t != 0 && t != 1) || !options.symmetric) return false;
    const PointsX3& key = t == 0 ? v : u;
    if (options.constraints.floor) {
      const Floor& floor = *options.constraints.floor;
      for (Eigen::Index i = 0; floor.vertices.empty() && i < key.rows(); ++i)
        if (key(i, 2) < floor.height) return false;
      for (int i : floor.vertices)
        if (key(i, 2) < floor.height) return false;
    }
    return (system.RowsAt(key) - Targets(t)).cwiseAbs().maxCoeff() <=
           kAtKey * (BoundingDiagonal(v) + BoundingDiagonal(u));
  }

  /// Frames whose parts are free; all steps work on rows of frames. Where the wanted volume is far
  /// away, the frame's facts stay empty and its volume is not corrected.
  std::vector<PointsX3> Together(const std::vector<double>& times,
                                 std::vector<std::optional<FrameFacts>>& facts) const {
    const FrameRows rows = system.SolveFree(SizeOf(times), [&](int first, EdgeBatch& edges) {
      paths->Evaluate({times.begin() + first, times.begin() + first + edges.frames}, edges);
    });
    const std::vector<std::vector<RowFrames::PartSums>> sums = together->Sums(rows, times);
    const double near_step =
        VolumeStepTuning::kNearStep * std::min(BoundingDiagonal(v), BoundingDiagonal(u));
    std::vector<Eigen::Matrix3d> bodies;
    std::vector<std::vector<RowFrames::Move>> moves(times.size());
    for (std::size_t k = 0; k < times.size(); ++k) {
      bodies.push_back(ExpOf(times[k] * maps.body_turn));
      facts[k].emplace();
      const std::vector<double> wanted =
          volumes ? PathVolumes(v_volumes, u_volumes, times[k]) : std::vector<double>();
      for (int p = 0; p < system.part_count(); ++p) {
        const RowFrames::PartSums& sum = sums[k][p];
        const bool corrected = volumes && volumes->closed_parts()[p] && std::isfinite(wanted[p]);
        double step = corrected ? StepToVolume(sum.volume, wanted[p]) : 0.0;
        const double move = std::abs(step) * (sum.longest + sum.field.norm());
        if (!(move <= near_step)) {
          step = 0;
          facts[k].reset();
        } else if (facts[k])
          facts[k]->volume_move = std::max(facts[k]->volume_move, move);
        moves[k].push_back(
            {step, centroids->At(p, times[k]) - bodies[k] * (sum.point + step * sum.field)});
      }
    }
    return together->Frames(rows, times, bodies, moves);
  }

  void Finish(double t, PointsX3& frame, FrameFacts& facts) const {
    std::vector<int> held;
    for (int pass = 0; pass < 4; ++pass) {
      if (volumes) {
        const std::vector<double> targets = PathVolumes(v_volumes, u_volumes, t);
        VolumeCorrection::Result result = volumes->Apply(
            frame, outward ? outward->At(t) : volumes->Direction(frame), targets, held);
        if (result.unreachable > 0 && outward)
          result = volumes->Apply(frame, volumes->Direction(frame), targets, held);
        facts.volume_move = std::max(facts.volume_move, result.largest_move);
      }
      loose_parts->Place(t, frame);
      if (!options.constraints.floor) return;
      const std::size_t before = held.size();
      const std::vector<int> now = system.LiftToFloor(frame, *options.constraints.floor);
      std::vector<int> merged;
      std::set_union(held.begin(), held.end(), now.begin(), now.end(), std::back_inserter(merged));
      held = std::move(merged);
      facts.floor_vertices = SizeOf(held);
      if (!volumes || held.size() == before) return;
    }
  }

  ArapOptions options;
  bool reversed;
  PointsX3 v, u;
  PoissonSystem system;
  SegmentMaps maps;
  std::optional<PairPaths> paths;
  std::optional<CentroidPaths> centroids;
  std::optional<DifferentialTurns> differential;
  std::optional<LooseParts> loose_parts;
  std::optional<VolumeCorrection> volumes;
  std::vector<double> v_volumes, u_volumes;
  std::optional<TurningField> outward;
  std::optional<RowFrames> together;  // used where frames need no more than one step to the volume
  ArapReport report;
};

ArapInterpolator::ArapInterpolator(const PointsX3& v, const PointsX3& u, const FacesX3& faces,
                                   const ArapOptions& options) {
  RequireKeys(v, u, faces);
  impl_ = std::make_unique<Impl>(v, u, faces, options);
  if (!options.choose_half_turns || impl_->report.turns.half_turns.empty()) return;
  ArapOptions other = options;
  other.choose_half_turns = false;
  const std::vector<std::vector<int>> limbs = impl_->report.turns.half_turns;
  std::size_t crossings = Crossings(At(0.5), faces).size();
  std::vector<TurnOverride> chosen;
  for (std::size_t k = 0; k < limbs.size() && crossings > 0; ++k) {
    other.turn_overrides.push_back(
        {.name = "half turn " + std::to_string(k), .faces = limbs[k], .extra_turns = -1});
    ArapInterpolator turned(v, u, faces, other);
    const std::size_t count = Crossings(turned.At(0.5), faces).size();
    if (count >= crossings) {
      other.turn_overrides.pop_back();
      continue;
    }
    crossings = count;
    chosen.push_back(other.turn_overrides.back());
    impl_ = std::move(turned.impl_);
  }
  impl_->report.half_turns = chosen;
}

ArapInterpolator::~ArapInterpolator() = default;
ArapInterpolator::ArapInterpolator(ArapInterpolator&&) noexcept = default;

PointsX3 ArapInterpolator::At(double t) const { return At(std::vector<double>{t}).front(); }

std::vector<PointsX3> ArapInterpolator::At(const std::vector<double>& given,
                                           std::vector<FrameFacts>* facts) const {
  const Impl& s = *impl_;
  const int count = SizeOf(given);
  std::vector<double> times = given;
  if (s.reversed)
    for (double& t : times) t = 1 - t;
  std::vector<std::optional<FrameFacts>> found(count);
  std::vector<PointsX3> frames = s.together ? s.Together(times, found) : s.OneByOne(times);
  ParallelFor(count, [&](std::int64_t k) {
    if (s.IsKey(times[k])) {
      frames[k] = times[k] == 0 ? s.v : s.u;
      found[k].emplace();
    } else if (found[k]) {
      s.loose_parts->Place(times[k], frames[k]);
    } else {
      s.Finish(times[k], frames[k], found[k].emplace());
    }
  });
  if (facts) {
    facts->clear();
    for (const auto& fact : found) facts->push_back(*fact);
  }
  return frames;
}

const ArapReport& ArapInterpolator::report() const { return impl_->report; }
const PoissonSystem& ArapInterpolator::system() const { return impl_->system; }

PointsX3 InterpolateLinearly(const PointsX3& v, const PointsX3& u, double t) {
  return (1 - t) * v + t * u;
}

}  // namespace keypose::interpolation
