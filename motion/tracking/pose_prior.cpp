#include "motion/tracking/pose_prior.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/numbers/rotations.h"

namespace keypose::motion {
namespace {

using Eigen::Vector3d;

/// The middle line of a segment, and how thick it is at least.
struct Capsule {
  int joint = 0;
  Vector3d from, to;  // in the joint's frame
  double radius = 0;
};

// Segments may overlap by this share of the sum of their radii: flesh gives way.
constexpr double kGive = 0.7;

std::array<Capsule, kSegments> CapsulesOf(const BodyShape& shape) {
  std::array<Capsule, kSegments> capsules;
  for (int s = 0; s < kSegments; ++s) {
    const SegmentModel& model = Segments()[s];
    Capsule& c = capsules[s];
    c.joint = model.joint;
    c.from = model.origin;
    c.to = model.origin + shape.lengths[model.length] * model.axis;
    const int middle = kStations / 2;
    c.radius = std::max(0.0, shape.radii[s](middle, 0) - std::abs(shape.radii[s](middle, 3)));
  }
  return capsules;
}

/// Pairs of segments that can meet without being neighbours.
const std::vector<std::pair<int, int>>& Pairs() {
  static const std::vector<std::pair<int, int>> pairs = [] {
    std::vector<std::pair<int, int>> all;
    for (const int arm : {4, 7}) {
      for (const int part : {arm + 1, arm + 2})
        for (const int trunk : {0, 1, 2, 3}) all.emplace_back(part, trunk);
      // An elbow rests on a thigh where the actor kneels or sits.
      for (const int part : {arm, arm + 1, arm + 2})
        for (const int thigh : {10, 13}) all.emplace_back(part, thigh);
    }
    for (const int left : {5, 6})
      for (const int right : {8, 9}) all.emplace_back(left, right);
    for (const auto& [a, b] :
         {std::pair{10, 13}, {11, 14}, {12, 15}, {11, 15}, {12, 14}, {10, 14}, {11, 13}})
      all.emplace_back(a, b);
    return all;
  }();
  return pairs;
}

/// Shares along two segments of their nearest points.
/// Source: Ericson, Real-Time Collision Detection, 2005, section 5.1.9.
std::pair<double, double> NearestShares(const Vector3d& p1, const Vector3d& q1, const Vector3d& p2,
                                        const Vector3d& q2) {
  const Vector3d d1 = q1 - p1, d2 = q2 - p2, r = p1 - p2;
  const double a = d1.squaredNorm(), e = d2.squaredNorm(), f = d2.dot(r);
  if (a < 1e-12 || e < 1e-12) return {0, 0};
  const double c = d1.dot(r), b = d1.dot(d2), denominator = a * e - b * b;
  double s = denominator > 1e-12 * a * e ? std::clamp((b * f - c * e) / denominator, 0.0, 1.0) : 0;
  double t = (b * s + f) / e;
  if (t < 0) {
    t = 0;
    s = std::clamp(-c / a, 0.0, 1.0);
  }
  if (t > 1) {
    t = 1;
    s = std::clamp((b - c) / a, 0.0, 1.0);
  }
  return {s, t};
}

}  // namespace

PoseSystem& PoseSystem::operator+=(const PoseSystem& other) {
  matrix += other.matrix;
  gradient += other.gradient;
  cost += other.cost;
  return *this;
}

QuadraticPrior RestPrior() {
  QuadraticPrior prior;
  prior.weight.tail<kDofs - 6>().setConstant(1 / (PriorTuning::kRest * PriorTuning::kRest));
  return prior;
}

std::vector<QuadraticPrior> CalmPriors(const DofVector& before, const DofVector& before_that) {
  QuadraticPrior speed, still;
  speed.mean = 2 * before - before_that;
  speed.weight.setConstant(1 / (PriorTuning::kTurnChange * PriorTuning::kTurnChange));
  speed.weight.head<3>().setConstant(1 / (PriorTuning::kMoveChange * PriorTuning::kMoveChange));
  still.mean = before;
  still.weight.tail<kDofs - 6>().setConstant(1 / (PriorTuning::kTurn * PriorTuning::kTurn));
  return {speed, still};
}

void AddQuadratic(const QuadraticPrior& prior, const DofVector& q, PoseSystem* system) {
  const DofVector off = q - prior.mean;
  system->matrix.diagonal() += prior.weight;
  system->gradient += prior.weight.cwiseProduct(off);
  system->cost += off.cwiseProduct(prior.weight).dot(off);
}

void AddLimits(const DofVector& q, PoseSystem* system) {
  const double weight = 1 / (PriorTuning::kLimit * PriorTuning::kLimit);
  for (int i = 0; i < kDofs; ++i) {
    const DofModel& dof = Dofs()[i];
    if (dof.low == dof.high) continue;
    const double off = q[i] - std::clamp(q[i], dof.low, dof.high);
    if (off == 0) continue;
    system->matrix(i, i) += weight;
    system->gradient[i] += weight * off;
    system->cost += weight * off * off;
  }
}

void AddOverlaps(const PosedBody& body, const BodyShape& shape, PoseSystem* system) {
  const std::array<Capsule, kSegments> capsules = CapsulesOf(shape);
  const double weight = 1 / (PriorTuning::kOverlap * PriorTuning::kOverlap);
  for (const auto& [i, j] : Pairs()) {
    const Capsule &a = capsules[i], &b = capsules[j];
    const Vector3d a0 = body.ToWorld(a.joint, a.from), a1 = body.ToWorld(a.joint, a.to);
    const Vector3d b0 = body.ToWorld(b.joint, b.from), b1 = body.ToWorld(b.joint, b.to);
    const auto [s, t] = NearestShares(a0, a1, b0, b1);
    const Vector3d on_a = a0 + s * (a1 - a0), on_b = b0 + t * (b1 - b0), apart = on_a - on_b;
    const double distance = apart.norm();
    const double overlap = kGive * (a.radius + b.radius) - distance;
    if (overlap <= 0 || distance < 1e-6) continue;
    // The nearest points may slide: at a minimum of the distance that changes nothing.
    DofVector row = DofVector::Zero();
    body.AddPoseRow(a.joint, on_a, -apart / distance, row.data());
    body.AddPoseRow(b.joint, on_b, apart / distance, row.data());
    system->matrix.noalias() += weight * row * row.transpose();
    system->gradient += weight * overlap * row;
    system->cost += weight * overlap * overlap;
  }
}

DofVector InChart(const BodyPose& pose, const Eigen::Quaterniond& chart) {
  DofVector q = pose.q;
  q.segment<3>(3) = LogOf(Eigen::Quaterniond(pose.RootRotation() * chart.conjugate()).normalized());
  return q;
}

}  // namespace keypose::motion
