// Makes neighbours in any graph of rotations turn the same way round, beyond 180 degrees.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace keypose::interpolation {

/// Rotation i is exp(turns[i]) exp(remainders[i]); turns of neighbours lie near each other.
struct LiftedTurns {
  std::vector<Eigen::Vector3d> turns, remainders;  ///< [rad]
  double largest_tear = 0;  ///< of neighbours: |turn - turn'| beyond what their rotations differ
                            ///< [rad]; a full turn where a ring closes wrongly
};

/// A tree grows from `root`, always over the link whose two rotations differ least. Each node
/// takes, of its rotation vectors (whole turns added about its own axis), the one nearest to its
/// parent's. Where none is near (close to whole turns there is no axis) it turns about its parent's
/// axis, by the angle nearest to its parent's. Up to half a turn that is all. Beyond, a rotation
/// vector magnifies noise of its rotation, so there the axis is taken from turns smoothed over the
/// graph, and what is left across that axis goes to `remainders`.
///
/// @param root        the node whose turn is the shortest one; nodes that cannot be reached start
/// from the least angle among them
/// @param neighbours  up to four of each node, -1 for none; symmetric
/// @param doubtful    1 for nodes to be reached last, as inverted tetrahedra
/// Source: after Gao et al., as-consistent-as-possible axis-angle, TVCG 2019, by a tree in place of
/// a global solve. Deterministic.
LiftedTurns LiftTurns(const std::vector<Eigen::Matrix3d>& rotations, int root,
                      const std::vector<std::array<int, 4>>& neighbours,
                      const std::vector<char>& doubtful);

/// The body that all else turns against.
struct Body {
  int node = 0;
  double share = 0;  ///< of all weight: what has its rotation to within 10 degrees
};
/// The node, of 32 spread over the list, whose rotation most of the weight shares.
Body BodyOf(const std::vector<Eigen::Matrix3d>& rotations, const std::vector<double>& weights);

/// The centre of the rotations around a node's: ten times the weighted mean of all within 30
/// degrees of the last one. One node's own rotation would not do: what it has across the common
/// axis comes out magnified near whole turns.
Eigen::Matrix3d MeanAround(int node, const std::vector<Eigen::Matrix3d>& rotations,
                           const std::vector<double>& weights);

/// The node whose turn lies nearest to the weighted mean of all: half-way along a body that only
/// bends or twists.
int MiddleOf(const std::vector<Eigen::Vector3d>& turns, const std::vector<double>& weights);

}  // namespace keypose::interpolation
