#include "interpolate/surface/face_paths.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"

namespace keypose::interpolation {

namespace {

using Plane = Eigen::Matrix<double, 3, 2>;

// Paths are smooth in time beyond 0 and 1. Central differences have an error of 1e-8 of the speed
// for several turns.
constexpr double kStep = 1e-5;

/// Whether `a` comes first in the order that decides from which key a pair is computed.
bool ComesFirst(const PointsX3& a, const PointsX3& b) {
  return !std::lexicographical_compare(b.data(), b.data() + b.size(), a.data(),
                                       a.data() + a.size());
}

/// Axes of a face's plane, from its edges alone.
Plane AxesOf(const Eigen::Matrix<double, 3, 2>& edges) {
  Plane axes;
  axes.col(0) = edges.col(0).normalized();
  axes.col(1) = edges.col(0).cross(edges.col(1)).normalized().cross(axes.col(0));
  return axes;
}

/// exp of [d o; o -d].
Eigen::Matrix2d ExpOfShear(const Eigen::Vector2d& shear) {
  const double r = shear.norm(), c = std::cosh(r), s = r > 1e-9 ? std::sinh(r) / r : 1;
  Eigen::Matrix2d m;
  m << c + s * shear[0], s * shear[1], s * shear[1], c - s * shear[0];
  return m;
}

double DoubledArea(const Eigen::Matrix<double, 3, 2>& edges) {
  return edges.col(0).cross(edges.col(1)).norm();
}

/// 1 + x, but always positive, however small x is; once differentiable.
double Positive(double x) { return x > -0.8 ? 1 + x : 0.2 * std::exp((x + 0.8) / 0.2); }

/// The velocity of a face: rotation in space, and stretch in its plane.
struct FaceVelocity {
  Eigen::Vector3d angular;
  double growth;          ///< half the rate of log area
  Eigen::Vector2d shear;  ///< (d, o) of [d o; o -d] in AxesOf
};

FaceVelocity VelocityOf(const Eigen::Matrix<double, 3, 2>& edges,
                        const Eigen::Matrix<double, 3, 2>& rate) {
  const Plane axes = AxesOf(edges);
  const Eigen::Vector3d normal = axes.col(0).cross(axes.col(1));
  const Eigen::Matrix<double, 3, 2> gradient = rate * (axes.transpose() * edges).inverse();
  const Eigen::Matrix2d in_plane = axes.transpose() * gradient;
  const Eigen::Vector2d out = (normal.transpose() * gradient).transpose();
  FaceVelocity v;
  // x moves out of the plane by (n x w) . x, and in the plane by the skew part about n.
  v.angular = 0.5 * (in_plane(1, 0) - in_plane(0, 1)) * normal - normal.cross(axes * out);
  v.growth = 0.5 * (in_plane(0, 0) + in_plane(1, 1));
  v.shear << 0.5 * (in_plane(0, 0) - in_plane(1, 1)), 0.5 * (in_plane(0, 1) + in_plane(1, 0));
  return v;
}

Eigen::Matrix<double, 3, 2> Get(const EdgeBatch& batch, Eigen::Index face, int frame) {
  const double* at = batch.Face(face) + frame;
  Eigen::Matrix<double, 3, 2> edges;
  for (int c = 0; c < 6; ++c) edges.data()[c] = at[c * batch.stride];
  return edges;
}

}  // namespace

FacePaths::Pair::Pair(const PointsX3& from, const PointsX3& to, const PoissonSystem& system,
                      const std::vector<TurnOverride>& overrides, Stretch stretch)
    : still(overrides.empty() && from == to), reversed(!ComesFirst(from, to)) {
  const PointsX3 &v = reversed ? to : from, &u = reversed ? from : to;
  SegmentMaps maps = FaceMapsOf(v, u, system.faces());
  if (still) {
    // A pose repeated in consecutive keys does not move, not even by rounding errors.
    for (FaceMap& map : maps.faces) {
      map.rotation.setIdentity();
      map.stretch.setIdentity();
      map.turn.setZero();
    }
  } else {
    turns = FollowTurns(system, maps, overrides, reversed);
    if (stretch == Stretch::kBalanced) SetGrowth(system, maps);
    if (turns.differential) differential.emplace(system, maps);
  }
  paths.emplace(v, u, system.faces(), maps, stretch);
  centroids.emplace(v, u, system.parts(), system.part_count(), maps.body_turn);
  body_turn = maps.body_turn;
  for (const FaceMap& map : maps.faces) {
    growth.push_back(map.growth);
    degenerate.push_back(map.degenerate ? 1 : 0);
  }
}

void FacePaths::Pair::Evaluate(const std::vector<double>& ways, EdgeBatch& edges) const {
  std::vector<double> times;
  for (const double way : ways) times.push_back(Time(way));
  if (!differential) return paths->Evaluate(times, edges);
  for (std::size_t k = 0; k < times.size(); ++k)
    paths->EvaluateWith(differential->At(times[k]), times[k], static_cast<int>(k), edges);
}

FacePaths::FacePaths(const std::vector<PointsX3>& keys, const PoissonSystem& system,
                     const Schedule& schedule,
                     const std::vector<std::vector<TurnOverride>>& overrides, Stretch stretch)
    : face_count_(system.faces().rows()) {
  pairs_.reserve(keys.size());
  for (std::size_t k = 0; k + 1 < keys.size(); ++k) {
    const std::vector<TurnOverride> turning =
        k < overrides.size() ? overrides[k] : std::vector<TurnOverride>();
    pairs_.emplace_back(keys[k], keys[k + 1], system, turning, stretch);
  }
  paces_.resize(pairs_.size());
  if (!AnySmooth(schedule)) return;
  SmoothFaces(schedule);
  SmoothCentroids(schedule, system.part_count());
}

std::vector<FacePaths::EndEdges> FacePaths::EdgesAtEnd(int span, double way) const {
  EdgeBatch batch(face_count_, 3);
  const std::vector<double> ways = {way - kStep, way, way + kStep};
  pairs_[span].Evaluate(ways, batch);
  std::vector<EndEdges> ends(face_count_);
  const Eigen::Matrix3d before = BodyTurn(span, ways[0]), at = BodyTurn(span, ways[1]),
                        after = BodyTurn(span, ways[2]);
  ParallelFor(
      face_count_,
      [&](std::int64_t f) {
        ends[f].at = at * Get(batch, f, 1);
        ends[f].rate = (after * Get(batch, f, 2) - before * Get(batch, f, 0)) / (2 * kStep);
        if (pairs_[span].still) ends[f].rate.setZero();
      },
      512);
  return ends;
}

double FacePaths::Motion::Dot(const Motion& o) const {
  return angular.dot(o.angular) + shear.dot(o.shear) + (growth + area) * (o.growth + o.area);
}

FacePaths::Motion FacePaths::Motion::Less(double share, const Motion& o) const {
  return {angular - share * o.angular, growth - share * o.growth, shear - share * o.shear,
          area - share * o.area};
}

std::vector<FacePaths::MotionPair> FacePaths::OwnMotions(int span,
                                                         const std::vector<EndEdges>& starts,
                                                         const std::vector<EndEdges>& ends) const {
  std::vector<MotionPair> motions(face_count_);
  ParallelFor(
      face_count_,
      [&](std::int64_t f) {
        if (straight_.count(f) > 0) return;
        const double region = GrowthOf(span, f);
        const FaceVelocity start = VelocityOf(starts[f].at, starts[f].rate),
                           end = VelocityOf(ends[f].at, ends[f].rate);
        motions[f].start = {start.angular, region, start.shear, start.growth - region};
        motions[f].end = {end.angular, region, end.shear, end.growth - region};
      },
      256);
  return motions;
}

/// Each face's motions at both ends of all spans, with one velocity at each key that spans share.
std::vector<std::vector<FacePaths::MotionPair>> FacePaths::SmoothMotions(
    const Schedule& schedule, const std::vector<std::vector<MotionPair>>& own) const {
  const int spans = SizeOf(own);
  std::vector<std::vector<MotionPair>> wanted = own;
  const auto smooth = [&](auto Motion::*part, Eigen::Index f) {
    EndVelocities<std::decay_t<decltype(Motion().*part)>> velocities;
    for (const auto& motions : own) {
      velocities.start.push_back(motions[f].start.*part);
      velocities.end.push_back(motions[f].end.*part);
    }
    velocities = SmoothVelocities(schedule, velocities);
    for (int k = 0; k < spans; ++k) {
      wanted[k][f].start.*part = velocities.start[k];
      wanted[k][f].end.*part = velocities.end[k];
    }
  };
  ParallelFor(
      face_count_,
      [&](std::int64_t f) {
        smooth(&Motion::angular, f);
        smooth(&Motion::growth, f);
        smooth(&Motion::shear, f);
        smooth(&Motion::area, f);
      },
      256);
  return wanted;
}

/// The change of pace at both ends of a span that does the part common to all faces.
FacePaths::Pace FacePaths::PaceOf(const std::vector<EndEdges>& starts,
                                  const std::vector<EndEdges>& ends,
                                  const std::vector<MotionPair>& own,
                                  const std::vector<MotionPair>& wanted) const {
  double start = 0, start_norm = 0, end = 0, end_norm = 0;
  for (Eigen::Index f = 0; f < face_count_; ++f) {
    const double weight = DoubledArea(starts[f].at) + DoubledArea(ends[f].at);
    start += weight * wanted[f].start.Dot(own[f].start);
    start_norm += weight * own[f].start.Dot(own[f].start);
    end += weight * wanted[f].end.Dot(own[f].end);
    end_norm += weight * own[f].end.Dot(own[f].end);
  }
  // Up to a slope of 3 sigma does not reverse.
  return {start_norm > 0 ? std::clamp(start / start_norm, 0.0, 3.0) : 1.0,
          end_norm > 0 ? std::clamp(end / end_norm, 0.0, 3.0) : 1.0};
}

void FacePaths::SmoothFaces(const Schedule& schedule) {
  const int spans = SizeOf(pairs_);
  std::vector<std::vector<EndEdges>> starts, ends;
  for (const Pair& pair : pairs_)
    for (Eigen::Index f = 0; f < face_count_; ++f)
      if (pair.degenerate[f]) straight_[f];
  std::vector<std::vector<MotionPair>> own;
  for (int k = 0; k < spans; ++k) {
    starts.push_back(EdgesAtEnd(k, 0));
    ends.push_back(EdgesAtEnd(k, 1));
    own.push_back(OwnMotions(k, starts.back(), ends.back()));
  }
  std::vector<std::vector<MotionPair>> wanted = SmoothMotions(schedule, own);
  for (int k = 0; k < spans; ++k) paces_[k] = PaceOf(starts[k], ends[k], own[k], wanted[k]);
  for (int k = 0; k < spans; ++k)
    ParallelFor(
        face_count_,
        [&](std::int64_t f) {
          MotionPair& bend = wanted[k][f];
          bend = {bend.start.Less(paces_[k].start, own[k][f].start),
                  bend.end.Less(paces_[k].end, own[k][f].end)};
          bend.start.area *= 2 * DoubledArea(starts[k][f].at);
          bend.end.area *= 2 * DoubledArea(ends[k][f].at) * std::exp(-2 * GrowthOf(k, f));
        },
        256);
  bends_ = std::move(wanted);
  for (auto& [f, path] : straight_) SmoothStraight(schedule, f, starts, ends);
}

void FacePaths::SmoothStraight(const Schedule& schedule, Eigen::Index f,
                               const std::vector<std::vector<EndEdges>>& starts,
                               const std::vector<std::vector<EndEdges>>& ends) {
  using Six = Eigen::Matrix<double, 6, 1>;
  EndVelocities<Six> own;
  for (const auto& span : starts)
    own.start.emplace_back(Eigen::Map<const Six>(span[f].rate.data()));
  for (const auto& span : ends) own.end.emplace_back(Eigen::Map<const Six>(span[f].rate.data()));
  const EndVelocities<Six> wanted = SmoothVelocities(schedule, own);
  EndVelocities<Edges>& bends = straight_[f];
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const Six start = wanted.start[k] - paces_[k].start * own.start[k],
              end = wanted.end[k] - paces_[k].end * own.end[k];
    bends.start.emplace_back(Eigen::Map<const Edges>(start.data()));
    bends.end.emplace_back(Eigen::Map<const Edges>(end.data()));
  }
}

double FacePaths::Sigma(int span, double way) const {
  const HermiteWeights weights(way);
  return way + weights.start * (paces_[span].start - 1) + weights.end * (paces_[span].end - 1);
}

double FacePaths::GrowthOf(int span, Eigen::Index f) const {
  const double growth = pairs_[span].growth[f];
  return pairs_[span].reversed ? -growth : growth;
}

void FacePaths::SmoothCentroids(const Schedule& schedule, int part_count) {
  for (int part = 0; part < part_count; ++part) {
    EndVelocities<Eigen::Vector3d> own;
    for (const Pair& pair : pairs_) {
      const auto rate = [&](double way) {
        const Eigen::Vector3d after = pair.centroids->At(part, pair.Time(way + kStep)),
                              before = pair.centroids->At(part, pair.Time(way - kStep));
        return Eigen::Vector3d(pair.still ? Eigen::Vector3d::Zero()
                                          : Eigen::Vector3d((after - before) / (2 * kStep)));
      };
      own.start.push_back(rate(0));
      own.end.push_back(rate(1));
    }
    EndVelocities<Eigen::Vector3d> bends = SmoothVelocities(schedule, own);
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      bends.start[k] -= paces_[k].start * own.start[k];
      bends.end[k] -= paces_[k].end * own.end[k];
    }
    centroid_bends_.push_back(std::move(bends));
  }
}

Eigen::Matrix3d FacePaths::BodyTurn(int span, double way) const {
  return ExpOf(pairs_[span].Time(Sigma(span, way)) * pairs_[span].body_turn);
}

Eigen::Vector3d FacePaths::Centroid(int span, double way, int part) const {
  const Eigen::Vector3d own = pairs_[span].centroids->At(part, pairs_[span].Time(Sigma(span, way)));
  if (centroid_bends_.empty()) return own;
  const HermiteWeights weights(way);
  return own + weights.start * centroid_bends_[part].start[span] +
         weights.end * centroid_bends_[part].end[span];
}

FacePaths::Edges FacePaths::Bent(int span, double sigma, const HermiteWeights& weights,
                                 const Eigen::Matrix3d& body, Eigen::Index f,
                                 const Edges& edges) const {
  if (!straight_.empty()) {
    const auto straight = straight_.find(f);
    if (straight != straight_.end())
      return edges + body.transpose() * (weights.start * straight->second.start[span] +
                                         weights.end * straight->second.end[span]);
  }
  const MotionPair& bend = bends_[span][f];
  const auto mixed = [&](auto Motion::*part) {
    using Value = std::decay_t<decltype(bend.start.*part)>;
    return Value(weights.start * (bend.start.*part) + weights.end * (bend.end.*part));
  };
  const Plane axes = AxesOf(edges);
  const double area = DoubledArea(edges) * std::exp(-2 * sigma * GrowthOf(span, f));
  const double scale =
      std::exp(mixed(&Motion::growth)) * std::sqrt(Positive(mixed(&Motion::area) / area));
  const Eigen::Matrix2d stretch = scale * ExpOfShear(mixed(&Motion::shear));
  return ExpOf(body.transpose() * mixed(&Motion::angular)) *
         (axes * (stretch * (axes.transpose() * edges)));
}

void FacePaths::Evaluate(int span, const std::vector<double>& ways, EdgeBatch& edges) const {
  std::vector<double> times;
  for (const double way : ways) times.push_back(Sigma(span, way));
  pairs_[span].Evaluate(times, edges);
  if (bends_.empty()) return;
  std::vector<HermiteWeights> weights;
  std::vector<Eigen::Matrix3d> bodies;
  for (const double way : ways) {
    weights.emplace_back(way);
    bodies.push_back(BodyTurn(span, way));
  }
  ParallelFor(
      face_count_,
      [&](std::int64_t f) {
        for (std::size_t k = 0; k < ways.size(); ++k) {
          const int frame = static_cast<int>(k);
          edges.Set(f, frame, Bent(span, times[k], weights[k], bodies[k], f, Get(edges, f, frame)));
        }
      },
      256);
}

int FacePaths::degenerate_faces() const {
  std::ptrdiff_t most = 0;
  for (const Pair& pair : pairs_)
    most = std::max(most, std::count(pair.degenerate.begin(), pair.degenerate.end(), 1));
  return static_cast<int>(most);
}

}  // namespace keypose::interpolation
