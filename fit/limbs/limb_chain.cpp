#include "fit/limbs/limb_chain.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/rotations.h"
#include "core/values/size_of.h"

namespace keypose::fit {
namespace {

constexpr int kRings = 16;
// The tip is rigid over so many radii: a hand, a ball at a tail's end.
constexpr double kRigidTip = 2.5;

/// Near a distance from the tip; never 0, since a limb of long faces may have no vertex near it.
double Nearness(double apart) {
  constexpr double kLeast = 1e-9;
  return std::exp(-apart * apart) + kLeast;
}

/// 0 on the body's side of a joint, 1 on the tip's.
double Share(double along, double joint, double half_width) {
  const double t = std::clamp((joint + half_width - along) / (2 * half_width), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace

LimbChain::LimbChain(const Limb& limb, const PointsX3& rest, const PointsX3& now)
    : limb_(limb), rest_(rest(limb.vertices, Eigen::all)) {
  const PointsX3 here = now(limb.vertices, Eigen::all);
  AddRings(here);
  PlaceJoints(here);
}

/// Half the limb's thickness: the spread of the vertices about the middle of their ring.
double LimbChain::Radius() const {
  constexpr int kBins = 8;
  std::vector<Eigen::RowVector3d> middle(kBins, Eigen::RowVector3d::Zero());
  std::vector<int> count(kBins, 0);
  const auto bin_of = [&](int i) {
    return std::min(kBins - 1, static_cast<int>(kBins * limb_.along[i] / limb_.length));
  };
  for (int i = 0; i < SizeOf(limb_.vertices); ++i) {
    middle[bin_of(i)] += rest_.row(i);
    ++count[bin_of(i)];
  }
  double sum = 0;
  for (int i = 0; i < SizeOf(limb_.vertices); ++i)
    sum += (rest_.row(i) - middle[bin_of(i)] / count[bin_of(i)]).norm();
  return sum / std::max(1, SizeOf(limb_.vertices));
}

/// The rigid motion of the vertices around a distance from the tip.
Rigid3 LimbChain::At(double along, const PointsX3& now) const {
  const double tip = std::min(kRigidTip * Radius(), limb_.length / 2), width = Radius();
  Eigen::VectorXd weights(limb_.along.size());
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    const double apart =
        along <= tip ? std::max(0.0, limb_.along[i] - tip) : limb_.along[i] - along;
    weights[i] = Nearness(apart / width);
  }
  const Similarity3 fitted = FitSimilarity(rest_, now, weights, false);
  return {Eigen::Quaterniond(fitted.rotation), fitted.translation};
}

void LimbChain::AddRings(const PointsX3& now) {
  for (int r = 0; r < kRings; ++r) {
    const double along = limb_.length * r / (kRings - 1);
    rings_.push_back({along, At(along, now)});
  }
}

/// At the base, in the middle, and where the tip begins.
void LimbChain::PlaceJoints(const PointsX3& now) {
  const double radius = Radius(), tip = std::min(kRigidTip * radius, limb_.length / 2);
  for (int j = 0; j < kJoints; ++j) {
    const double from = std::max(tip, limb_.length - radius);
    joint_along_.push_back(from + (tip - from) * j / (kJoints - 1));
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weight = 0;
    for (Eigen::Index i = 0; i < now.rows(); ++i) {
      const double w = Nearness(2 * (limb_.along[i] - joint_along_[j]) / radius);
      sum += w * now.row(i).transpose();
      weight += w;
    }
    joint_.push_back(sum / weight);
  }
}

std::vector<Rigid3> LimbChain::TurnedRings(const Turns& turns) const {
  const double half_width = limb_.length / (2 * kJoints);
  std::vector<Rigid3> rings;
  for (const Ring& ring : rings_) {
    Rigid3 moved = ring.now_from_rest;
    for (int j = kJoints - 1; j >= 0; --j) {
      const double share = Share(ring.along, joint_along_[j], half_width);
      const Eigen::Quaterniond turn = QuaternionOf(share * turns.segment<3>(3 * j));
      moved.rotation = turn * moved.rotation;
      moved.translation = turn * (moved.translation - joint_[j]) + joint_[j];
    }
    rings.push_back(moved);
  }
  return rings;
}

Eigen::RowVector3d LimbChain::On(const std::vector<Rigid3>& rings, int vertex) const {
  const double at = limb_.along[vertex] / limb_.length * (kRings - 1);
  const int r = std::min(kRings - 2, static_cast<int>(at));
  const Eigen::Vector3d x = rest_.row(vertex).transpose();
  return ((1 - (at - r)) * (rings[r] * x) + (at - r) * (rings[r + 1] * x)).transpose();
}

PointsX3 LimbChain::Turned(const Turns& turns) const {
  const std::vector<Rigid3> rings = TurnedRings(turns);
  PointsX3 moved(rest_.rows(), 3);
  for (int i = 0; i < moved.rows(); ++i) moved.row(i) = On(rings, i);
  return moved;
}

PointsX3 LimbChain::Turned(const Turns& turns, const std::vector<int>& some) const {
  const std::vector<Rigid3> rings = TurnedRings(turns);
  PointsX3 moved(SizeOf(some), 3);
  for (int i = 0; i < SizeOf(some); ++i) moved.row(i) = On(rings, some[i]);
  return moved;
}

}  // namespace keypose::fit
