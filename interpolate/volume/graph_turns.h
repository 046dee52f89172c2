// Makes neighbours in any graph of rotations turn the same way round, beyond 180 degrees.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace keypose::interpolation {

/// Rotation i is exp(turns[i]) exp(remainders[i]); turns of neighbours lie near each other.
struct LiftedTurns {
  std::vector<Eigen::Vector3d> turns, remainders;  ///< [rad]
  double largest_tear = 0;  ///< of neighbours: |turn - turn'| beyond the difference of their
                            ///< rotations [rad]; a full turn where a ring does not close
};

/// A tree grows from `root`, always over the link whose two rotations differ least. A node's
/// candidates are its rotation vectors (with whole turns about its own axis); it takes the one
/// nearest to its parent's. Where none is near (close to whole turns the axis is undefined) it
/// turns about its parent's axis, by the angle nearest to its parent's. For turns up to half a turn
/// this is the result. Beyond, a rotation vector amplifies the noise of its rotation. There the
/// axis comes from turns smoothed over the graph, and `remainders` hold the rest of the rotation,
/// across that axis.
///
/// @param root        the node with the shortest turn; components that it does not reach start at
/// their node of smallest angle
/// @param neighbours  up to four of each node, -1 for none; symmetric
/// @param doubtful    1 for nodes to visit last, such as inverted tetrahedra
/// Source: after Gao et al., as-consistent-as-possible axis-angle, TVCG 2019, by a tree in place of
/// a global solve. Deterministic.
LiftedTurns LiftTurns(const std::vector<Eigen::Matrix3d>& rotations, int root,
                      const std::vector<std::array<int, 4>>& neighbours,
                      const std::vector<char>& doubtful);

/// The reference for all other turns.
struct Body {
  int node = 0;
  double share = 0;  ///< share of the weight whose rotation is within 10 degrees of the node's
};
/// The node, of 32 spread over the list, whose rotation has the largest share of the weight.
Body BodyOf(const std::vector<Eigen::Matrix3d>& rotations, const std::vector<double>& weights);

/// The mean rotation around a node's: ten iterations of the weighted mean of all rotations within
/// 30 degrees of the last one. The node's own rotation is not enough: its component across the
/// common axis is amplified near whole turns.
Eigen::Matrix3d MeanAround(int node, const std::vector<Eigen::Matrix3d>& rotations,
                           const std::vector<double>& weights);

/// The node whose turn is nearest to the weighted mean of all: the middle of a body that only bends
/// or twists.
int MiddleOf(const std::vector<Eigen::Vector3d>& turns, const std::vector<double>& weights);

}  // namespace keypose::interpolation
