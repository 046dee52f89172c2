// A chain of rods of fixed lengths laid along a curve: as the paper does it, and with both ends
// held.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armature/matching/polyline.h"
#include "core/values/mesh.h"

namespace keypose::armature {

/// Which end keeps its place when the chain is too short, or has too long a rod, for both.
enum class Unreachable { kKeepNear, kKeepFar, kSplit };

struct MatchOptions {
  /// Weight of each rod's direction beside the joints' distances from the curve, both relative to
  /// the chain's length. It decides where a chain that is longer than its curve puts the rest, and
  /// keeps that from jumping; >= 0.
  double direction_weight = 1e-2;
  /// Weight of the change against the match before; 0: none. Above 0 the result lags.
  double calm_weight = 0;
  Unreachable unreachable = Unreachable::kSplit;
  int max_iterations = 60;
};

/// A chain of M rods, from its near anchor to its far anchor.
struct ChainMatch {
  PointsX3 joints;      ///< M+1 x 3, in the curve's unit
  PointsX3 directions;  ///< M x 3 unit; joints[i+1] = joints[i] + lengths[i] * directions[i]
  double near_gap = 0, far_gap = 0;  ///< distance of the two ends from the curve's ends
  /// of the inner joints from the whole curve; 0 without inner joints
  double mean_distance = 0;
  int iterations = 0;
  bool reachable = true;  ///< both ends can be met
  bool converged = true;
};

/// Source: the paper, "Matching". The near anchor is exact. Each further joint is the first point
/// of the curve after the last joint that is a rod's length away; where there is none, the last
/// rod's direction is kept. The error ends up at the far anchor.
///
/// @param lengths  M >= 1, positive
/// @throws InputError  a length that is not positive and finite
ChainMatch MatchGreedily(const Polyline& curve, const Eigen::VectorXd& lengths);

/// Both anchors exact, rods as long as they are, least squared distance of the inner joints from
/// the curve. Each joint stays on its own part of the curve: halfway to the shares of the length
/// that its neighbours have, so that joints cannot change their order.
///
/// @param directions  M x 3 unit: what each rod's direction shall resemble; empty: the curve's
/// @param before      the match of the moment before, from which the search starts; may be null
/// @throws InputError  wrong shape, a length that is not positive, or not finite
/// Cost: O(M^2) a round, mostly 5 rounds. No memory of earlier calls but `before`.
/// Source: the paper's future work 3. Newton's method on the directions' spheres, with the far
/// anchor as a constraint (docs/algorithms/armature.md).
ChainMatch MatchBothEnds(const Polyline& curve, const Eigen::VectorXd& lengths,
                         const PointsX3& directions, const ChainMatch* before,
                         const MatchOptions& options);

/// The value that MatchBothEnds makes small, for given directions; lengths relative to the chain's.
double MatchCost(const Polyline& curve, const Eigen::VectorXd& lengths, const PointsX3& wanted,
                 const ChainMatch* before, const MatchOptions& options, const PointsX3& directions);

/// The part of the curve that an inner joint k = 1 ... M-1 may be matched to.
struct CurvePart {
  double from = 0, to = 0;
};
std::vector<CurvePart> PartsOf(const Polyline& curve, const Eigen::VectorXd& lengths);

}  // namespace keypose::armature
