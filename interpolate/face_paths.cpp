#include "interpolate/face_paths.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace keypose::interpolation {

namespace {

using Plane = Eigen::Matrix<double, 3, 2>;

// Paths are smooth in time beyond 0 and 1: central differences are good to 1e-8 of the speed at many turns.
constexpr double kStep = 1e-5;

/// Whether `a` comes first in the order that decides from which key a pair is computed.
bool ComesFirst(const PointsX3& a, const PointsX3& b) {
  return !std::lexicographical_compare(b.data(), b.data() + b.size(), a.data(), a.data() + a.size());
}

/// Axes of a face's plane that follow from its edges alone.
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

double DoubledArea(const Eigen::Matrix<double, 3, 2>& edges) { return edges.col(0).cross(edges.col(1)).norm(); }

/// 1 + x, but never below zero however far x falls; once differentiable.
double Positive(double x) { return x > -0.8 ? 1 + x : 0.2 * std::exp((x + 0.8) / 0.2); }

/// A face's velocity: how it turns in space, and how it stretches in its plane.
struct FaceVelocity {
  Eigen::Vector3d angular;
  double growth;          ///< half the rate of log area
  Eigen::Vector2d shear;  ///< (d, o) of [d o; o -d] in AxesOf
};

FaceVelocity VelocityOf(const Eigen::Matrix<double, 3, 2>& edges, const Eigen::Matrix<double, 3, 2>& rate) {
  const Plane axes = AxesOf(edges);
  const Eigen::Vector3d normal = axes.col(0).cross(axes.col(1));
  const Eigen::Matrix<double, 3, 2> gradient = rate * (axes.transpose() * edges).inverse();
  const Eigen::Matrix2d in_plane = axes.transpose() * gradient;
  const Eigen::Vector2d out = (normal.transpose() * gradient).transpose();
  FaceVelocity v;
  // Out of the plane x moves by (n x w) . x, in it by the skew part about n.
  v.angular = 0.5 * (in_plane(1, 0) - in_plane(0, 1)) * normal - normal.cross(axes * out);
  v.growth = 0.5 * (in_plane(0, 0) + in_plane(1, 1));
  v.shear << 0.5 * (in_plane(0, 0) - in_plane(1, 1)), 0.5 * (in_plane(0, 1) + in_plane(1, 0));
  return v;
}

/// Wanted less own velocities.
template <class Value>
EndVelocities<Value> BendsOf(const Schedule& schedule, const EndVelocities<Value>& own) {
  EndVelocities<Value> bends = SmoothVelocities(schedule, own);
  for (std::size_t k = 0; k < own.start.size(); ++k) bends.start[k] -= own.start[k], bends.end[k] -= own.end[k];
  return bends;
}

Eigen::Matrix<double, 3, 2> Get(const EdgeBatch& batch, Eigen::Index face, int frame) {
  const double* at = batch.Face(face) + frame;
  Eigen::Matrix<double, 3, 2> edges;
  for (int c = 0; c < 6; ++c) edges.data()[c] = at[c * batch.stride];
  return edges;
}

}  // namespace

FacePaths::Pair::Pair(const PointsX3& from, const PointsX3& to, const PoissonSystem& system, const std::vector<TurnOverride>& overrides,
                      Stretch stretch)
    : still(overrides.empty() && from == to), reversed(!ComesFirst(from, to)) {
  const PointsX3 &v = reversed ? to : from, &u = reversed ? from : to;
  maps = FaceMapsOf(v, u, system.faces());
  if (still) {
    // A pose that stands twice in a row does not move, not even by rounding errors.
    for (FaceMap& map : maps.faces) map.rotation.setIdentity(), map.stretch.setIdentity(), map.turn.setZero();
  } else {
    turns = FollowTurns(system, maps, overrides, reversed);
    if (stretch == Stretch::kBalanced) SetGrowth(system, maps);
    if (turns.differential) differential.emplace(system, maps);
  }
  paths.emplace(v, u, system.faces(), maps, stretch);
  centroids.emplace(v, u, system.parts(), system.part_count(), maps.body_turn);
}

void FacePaths::Pair::Evaluate(const std::vector<double>& ways, EdgeBatch& edges) const {
  std::vector<double> times;
  for (const double way : ways) times.push_back(Time(way));
  if (!differential) return paths->Evaluate(times, edges);
  for (std::size_t k = 0; k < times.size(); ++k) paths->EvaluateWith(differential->At(times[k]), times[k], static_cast<int>(k), edges);
}

FacePaths::FacePaths(const std::vector<PointsX3>& keys, const PoissonSystem& system, const Schedule& schedule,
                     const std::vector<std::vector<TurnOverride>>& overrides, Stretch stretch)
    : face_count_(system.faces().rows()) {
  pairs_.reserve(keys.size());
  for (std::size_t k = 0; k + 1 < keys.size(); ++k) {
    const std::vector<TurnOverride> turning = k < overrides.size() ? overrides[k] : std::vector<TurnOverride>();
    pairs_.emplace_back(keys[k], keys[k + 1], system, turning, stretch);
  }
  if (!AnySmooth(schedule)) return;
  SmoothFaces(schedule);
  SmoothCentroids(schedule, system.part_count());
}

std::vector<FacePaths::EndEdges> FacePaths::EdgesAtEnd(int span, double way) const {
  EdgeBatch batch(face_count_, 3);
  const std::vector<double> ways = {way - kStep, way, way + kStep};
  pairs_[span].Evaluate(ways, batch);
  std::vector<EndEdges> ends(face_count_);
  const Eigen::Matrix3d before = BodyTurn(span, ways[0]), at = BodyTurn(span, ways[1]), after = BodyTurn(span, ways[2]);
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

void FacePaths::SmoothFaces(const Schedule& schedule) {
  const int spans = static_cast<int>(pairs_.size());
  std::vector<std::vector<EndEdges>> starts, ends;
  std::vector<char> degenerate(face_count_, 0);
  for (int k = 0; k < spans; ++k) {
    starts.push_back(EdgesAtEnd(k, 0));
    ends.push_back(EdgesAtEnd(k, 1));
    for (Eigen::Index f = 0; f < face_count_; ++f) degenerate[f] |= static_cast<char>(pairs_[k].maps.faces[f].degenerate);
  }
  bends_.assign(spans, std::vector<BendPair>(face_count_));
  for (Eigen::Index f = 0; f < face_count_; ++f)
    if (degenerate[f]) straight_[f];
  ParallelFor(
      face_count_,
      [&](std::int64_t f) {
        std::vector<const EndEdges*> start, end;
        for (int k = 0; k < spans; ++k) start.push_back(&starts[k][f]), end.push_back(&ends[k][f]);
        SmoothFace(schedule, f, start, end);
      },
      256);
}

void FacePaths::SmoothFace(const Schedule& schedule, Eigen::Index f, const std::vector<const EndEdges*>& starts,
                           const std::vector<const EndEdges*>& ends) {
  if (const auto straight = straight_.find(f); straight != straight_.end()) {
    using Six = Eigen::Matrix<double, 6, 1>;
    EndVelocities<Six> own;
    for (const EndEdges* e : starts) own.start.emplace_back(Eigen::Map<const Six>(e->rate.data()));
    for (const EndEdges* e : ends) own.end.emplace_back(Eigen::Map<const Six>(e->rate.data()));
    const EndVelocities<Six> bends = BendsOf(schedule, own);
    for (const Six& b : bends.start) straight->second.start.emplace_back(Eigen::Map<const Edges>(b.data()));
    for (const Six& b : bends.end) straight->second.end.emplace_back(Eigen::Map<const Edges>(b.data()));
    return;
  }
  EndVelocities<Eigen::Vector3d> angular;
  EndVelocities<double> growth, area;
  EndVelocities<Eigen::Vector2d> shear;
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const double region = GrowthOf(static_cast<int>(k), f);
    growth.start.push_back(region), growth.end.push_back(region);
    const FaceVelocity start = VelocityOf(starts[k]->at, starts[k]->rate), end = VelocityOf(ends[k]->at, ends[k]->rate);
    angular.start.push_back(start.angular), angular.end.push_back(end.angular);
    shear.start.push_back(start.shear), shear.end.push_back(end.shear);
    area.start.push_back(start.growth - region), area.end.push_back(end.growth - region);
  }
  angular = BendsOf(schedule, angular), growth = BendsOf(schedule, growth), shear = BendsOf(schedule, shear),
  area = BendsOf(schedule, area);
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const double at_start = DoubledArea(starts[k]->at), at_end = DoubledArea(ends[k]->at) * std::exp(-2 * GrowthOf(static_cast<int>(k), f));
    bends_[k][f].start = {angular.start[k], growth.start[k], shear.start[k], 2 * at_start * area.start[k]};
    bends_[k][f].end = {angular.end[k], growth.end[k], shear.end[k], 2 * at_end * area.end[k]};
  }
}

double FacePaths::GrowthOf(int span, Eigen::Index f) const {
  const double growth = pairs_[span].maps.faces[f].growth;
  return pairs_[span].reversed ? -growth : growth;
}

void FacePaths::SmoothCentroids(const Schedule& schedule, int part_count) {
  for (int part = 0; part < part_count; ++part) {
    EndVelocities<Eigen::Vector3d> own;
    for (const Pair& pair : pairs_) {
      const auto rate = [&](double way) {
        const Eigen::Vector3d after = pair.centroids->At(part, pair.Time(way + kStep)),
                              before = pair.centroids->At(part, pair.Time(way - kStep));
        return Eigen::Vector3d(pair.still ? Eigen::Vector3d::Zero() : Eigen::Vector3d((after - before) / (2 * kStep)));
      };
      own.start.push_back(rate(0));
      own.end.push_back(rate(1));
    }
    centroid_bends_.push_back(BendsOf(schedule, own));
  }
}

Eigen::Matrix3d FacePaths::BodyTurn(int span, double way) const { return ExpOf(pairs_[span].Time(way) * pairs_[span].maps.body_turn); }

Eigen::Vector3d FacePaths::Centroid(int span, double way, int part) const {
  const Eigen::Vector3d own = pairs_[span].centroids->At(part, pairs_[span].Time(way));
  if (centroid_bends_.empty()) return own;
  const HermiteWeights weights(way);
  return own + weights.start * centroid_bends_[part].start[span] + weights.end * centroid_bends_[part].end[span];
}

FacePaths::Edges FacePaths::Bent(int span, double way, const HermiteWeights& weights, const Eigen::Matrix3d& body, Eigen::Index f,
                                 const Edges& edges) const {
  if (!straight_.empty()) {
    const auto straight = straight_.find(f);
    if (straight != straight_.end())
      return edges + body.transpose() * (weights.start * straight->second.start[span] + weights.end * straight->second.end[span]);
  }
  const BendPair& bend = bends_[span][f];
  const auto mixed = [&](auto Bend::*part) {
    using Value = std::decay_t<decltype(bend.start.*part)>;
    return Value(weights.start * (bend.start.*part) + weights.end * (bend.end.*part));
  };
  const Plane axes = AxesOf(edges);
  const double area = DoubledArea(edges) * std::exp(-2 * way * GrowthOf(span, f));
  const double scale = std::exp(mixed(&Bend::growth)) * std::sqrt(Positive(mixed(&Bend::area) / area));
  const Eigen::Matrix2d stretch = scale * ExpOfShear(mixed(&Bend::shear));
  return ExpOf(body.transpose() * mixed(&Bend::angular)) * (axes * (stretch * (axes.transpose() * edges)));
}

void FacePaths::Evaluate(int span, const std::vector<double>& ways, EdgeBatch& edges) const {
  pairs_[span].Evaluate(ways, edges);
  if (bends_.empty()) return;
  std::vector<HermiteWeights> weights;
  std::vector<Eigen::Matrix3d> bodies;
  for (const double way : ways) weights.emplace_back(way), bodies.push_back(BodyTurn(span, way));
  ParallelFor(
      face_count_,
      [&](std::int64_t f) {
        for (std::size_t k = 0; k < ways.size(); ++k) {
          const int frame = static_cast<int>(k);
          edges.Set(f, frame, Bent(span, ways[k], weights[k], bodies[k], f, Get(edges, f, frame)));
        }
      },
      256);
}

int FacePaths::degenerate_faces() const {
  std::ptrdiff_t most = 0;
  for (const Pair& pair : pairs_)
    most = std::max(most, std::count_if(pair.maps.faces.begin(), pair.maps.faces.end(), [](const FaceMap& m) { return m.degenerate; }));
  return static_cast<int>(most);
}

}  // namespace keypose::interpolation
