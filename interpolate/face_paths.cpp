#include "interpolate/face_paths.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace keypose::interpolation {

namespace {

using Edges = Eigen::Matrix<double, 3, 2>;
using Plane = Eigen::Matrix<double, 3, 2>;

Edges EdgesOf(const PointsX3& p, const FacesX3& faces, Eigen::Index f) {
  Edges edges;
  edges << (p.row(faces(f, 1)) - p.row(faces(f, 0))).transpose(), (p.row(faces(f, 2)) - p.row(faces(f, 0))).transpose();
  return edges;
}

/// Axes of a face's plane that follow from its edges alone.
Plane AxesOf(const Edges& edges) {
  Plane axes;
  axes.col(0) = edges.col(0).normalized();
  axes.col(1) = edges.col(0).cross(edges.col(1)).normalized().cross(axes.col(0));
  return axes;
}

Eigen::Matrix2d MatrixOf(const Eigen::Vector3d& symmetric) {
  Eigen::Matrix2d m;
  m << symmetric[0] + symmetric[1], symmetric[2], symmetric[2], symmetric[0] - symmetric[1];
  return m;
}

Eigen::Vector3d VectorOf(const Eigen::Matrix2d& m) {
  return {0.5 * (m(0, 0) + m(1, 1)), 0.5 * (m(0, 0) - m(1, 1)), 0.5 * (m(0, 1) + m(1, 0))};
}

/// A symmetric tensor of the plane, from axes `from` into axes `to` of the same plane.
Eigen::Vector3d Turned(const Eigen::Vector3d& symmetric, const Plane& from, const Plane& to) {
  const Eigen::Matrix2d c = to.transpose() * from;
  return VectorOf(c * MatrixOf(symmetric) * c.transpose());
}

/// d/dt log S(t) at t, as LogStretch has it. S(t) commutes with itself at all t, so this is the whole rate of stretch.
Eigen::Vector3d StretchRate(const FaceMap& map, Stretch stretch, double t) {
  // Every law is smooth in t and known in closed form beyond [0,1]: a central difference is good to 1e-10.
  constexpr double kStep = 1e-5;
  return (LogStretch(StretchAt(map, stretch, t + kStep)) - LogStretch(StretchAt(map, stretch, t - kStep))) / (2 * kStep);
}

// Angular velocities of exp(t body_turn) exp(t turn) exp(t remainder), in the world.
Eigen::Vector3d AngularStart(const SegmentMaps& maps, const FaceMap& map) { return maps.body_turn + map.turn + map.remainder; }
Eigen::Vector3d AngularEnd(const SegmentMaps& maps, const FaceMap& map) {
  return maps.body_turn + ExpOf(maps.body_turn) * (map.turn + ExpOf(map.turn) * map.remainder);
}

bool AnySmooth(const Schedule& schedule) {
  for (int key = 0; key <= static_cast<int>(schedule.spans.size()); ++key) {
    const KeyMeeting meeting = MeetingAt(schedule, key);
    if (meeting.before != Meeting::kFree || meeting.after != Meeting::kFree) return true;
  }
  return false;
}

/// A pose that stands twice in a row: nothing moves, not even by rounding errors.
SegmentMaps StillMaps(const PointsX3& v, const FacesX3& faces) {
  SegmentMaps maps = FaceMapsOf(v, v, faces);
  for (FaceMap& map : maps.faces) {
    map.rotation.setIdentity();
    map.turn.setZero();
    map.stretch.setIdentity();
  }
  return maps;
}

}  // namespace

Eigen::Vector3d LogStretch(const Eigen::Matrix2d& s) {
  const double mean = 0.5 * (s(0, 0) + s(1, 1)), d = 0.5 * (s(0, 0) - s(1, 1)), o = 0.5 * (s(0, 1) + s(1, 0)), r = std::hypot(d, o);
  const double high = mean + r, low = (s(0, 0) * s(1, 1) - s(0, 1) * s(1, 0)) / high;
  const double log_high = std::log(high), log_low = std::log(low);
  // Where both are nearly one, the difference of logarithms over that of the values is their derivative.
  const double ratio = r > 1e-9 * high ? 0.5 * (log_high - log_low) / r : 1 / mean;
  return {0.5 * (log_high + log_low), ratio * d, ratio * o};
}

Eigen::Matrix2d ExpStretch(const Eigen::Vector3d& log) {
  const double scale = std::exp(log[0]), r = std::hypot(log[1], log[2]);
  const double c = scale * std::cosh(r), s = r > 1e-9 ? scale * std::sinh(r) / r : scale;
  Eigen::Matrix2d m;
  m << c + s * log[1], s * log[2], s * log[2], c - s * log[1];
  return m;
}

FacePaths::FacePaths(const std::vector<PointsX3>& keys, const PoissonSystem& system, const Schedule& schedule,
                     const std::vector<std::vector<TurnOverride>>& overrides, Stretch stretch)
    : faces_(system.faces()), stretch_(stretch) {
  const Eigen::Index count = faces_.rows();
  for (const PointsX3& key : keys) {
    edges_.emplace_back(count);
    for (Eigen::Index f = 0; f < count; ++f) edges_.back()[f] = EdgesOf(key, faces_, f);
  }
  for (std::size_t k = 0; k + 1 < keys.size(); ++k) {
    const bool still = keys[k] == keys[k + 1];
    maps_.push_back(still ? StillMaps(keys[k], faces_) : FaceMapsOf(keys[k], keys[k + 1], faces_));
    const std::vector<TurnOverride> turning = k < overrides.size() ? overrides[k] : std::vector<TurnOverride>();
    turns_.push_back(still ? TurnReport() : FollowTurns(system, maps_.back(), turning));
  }
  if (!AnySmooth(schedule)) return;
  bends_.assign(maps_.size(), std::vector<BendPair>(count));
  std::vector<char> degenerate(count, 0);
  for (const SegmentMaps& maps : maps_)
    for (Eigen::Index f = 0; f < count; ++f) degenerate[f] |= static_cast<char>(maps.faces[f].degenerate);
  ParallelFor(
      count, [&](std::int64_t f) { degenerate[f] ? void() : SmoothFace(schedule, f); }, 256);
  for (Eigen::Index f = 0; f < count; ++f)
    if (degenerate[f]) SmoothStraight(schedule, f);
}

void FacePaths::SmoothFace(const Schedule& schedule, Eigen::Index f) {
  const std::size_t spans = maps_.size();
  EndVelocities<Eigen::Vector3d> turning;
  EndVelocities<double> growing;
  EndVelocities<Eigen::Vector2d> shearing;
  const auto add = [](const Eigen::Vector3d& rate, std::vector<double>& growth, std::vector<Eigen::Vector2d>& shear) {
    growth.push_back(rate[0]);
    shear.emplace_back(rate.tail<2>());
  };
  std::vector<Plane> axes_start, axes_end, own_start, own_end;  // per span: of the key alone, and of the span's map
  for (std::size_t k = 0; k < spans; ++k) {
    const FaceMap& map = maps_[k].faces[f];
    axes_start.push_back(AxesOf(edges_[k][f]));
    axes_end.push_back(AxesOf(edges_[k + 1][f]));
    own_start.push_back(map.frame);
    own_end.push_back(map.rotation * map.frame);
    turning.start.push_back(AngularStart(maps_[k], map));
    turning.end.push_back(AngularEnd(maps_[k], map));
    add(Turned(StretchRate(map, stretch_, 0), own_start[k], axes_start[k]), growing.start, shearing.start);
    add(Turned(StretchRate(map, stretch_, 1), own_end[k], axes_end[k]), growing.end, shearing.end);
  }
  const auto turns = SmoothVelocities(schedule, turning);
  const auto grows = SmoothVelocities(schedule, growing);
  const auto shears = SmoothVelocities(schedule, shearing);
  for (std::size_t k = 0; k < spans; ++k) {
    BendPair& bend = bends_[k][f];
    bend.start.angular = turns.start[k] - turning.start[k];
    bend.end.angular = turns.end[k] - turning.end[k];
    Eigen::Vector3d start, end;
    start << grows.start[k] - growing.start[k], shears.start[k] - shearing.start[k];
    end << grows.end[k] - growing.end[k], shears.end[k] - shearing.end[k];
    bend.start.stretch = Turned(start, axes_start[k], own_start[k]);
    bend.end.stretch = Turned(end, axes_end[k], own_end[k]);
  }
}

void FacePaths::SmoothStraight(const Schedule& schedule, Eigen::Index f) {
  const auto flat = [](const Edges& e) { return Straight(Eigen::Map<const Straight>(e.data())); };
  EndVelocities<Straight> own;
  for (std::size_t k = 0; k < maps_.size(); ++k) own.start.push_back(flat(edges_[k + 1][f]) - flat(edges_[k][f]));
  own.end = own.start;
  EndVelocities<Straight>& bends = straight_[f] = SmoothVelocities(schedule, own);
  for (std::size_t k = 0; k < maps_.size(); ++k) bends.start[k] -= own.start[k], bends.end[k] -= own.end[k];
}

Edges FacePaths::EdgesAt(int span, double way, Eigen::Index f) const {
  const HermiteWeights weights(way);
  const FaceMap& map = maps_[span].faces[f];
  const auto straight = straight_.empty() ? straight_.end() : straight_.find(f);
  if (map.degenerate || straight != straight_.end()) {
    Edges edges = (1 - way) * edges_[span][f] + way * edges_[span + 1][f];
    if (straight == straight_.end()) return edges;
    const Straight bend = weights.start * straight->second.start[span] + weights.end * straight->second.end[span];
    return edges + Eigen::Map<const Edges>(bend.data());
  }
  const Eigen::Matrix3d turn = RotationAt(maps_[span], f, way);
  const Eigen::Matrix2d flat = StretchAt(map, stretch_, way) * (map.frame.transpose() * edges_[span][f]);
  if (bends_.empty()) return turn * (map.frame * flat);
  const BendPair& bend = bends_[span][f];
  const Eigen::Matrix2d stretch = ExpStretch(weights.start * bend.start.stretch + weights.end * bend.end.stretch);
  return ExpOf(weights.start * bend.start.angular + weights.end * bend.end.angular) * (turn * (map.frame * (stretch * flat)));
}

int FacePaths::degenerate_faces() const {
  std::ptrdiff_t most = 0;
  for (const SegmentMaps& maps : maps_)
    most = std::max(most, std::count_if(maps.faces.begin(), maps.faces.end(), [](const FaceMap& m) { return m.degenerate; }));
  return static_cast<int>(most);
}

}  // namespace keypose::interpolation
