// Makes neighbours in any graph of rotations turn the same way round, beyond 180 degrees.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace keypose::interpolation {

/// exp(turns[i]) exp(remainders[i]) is rotation i; turns of neighbours lie near each other.
struct LiftedTurns {
  std::vector<Eigen::Vector3d> turns, remainders;  ///< [rad]
  double largest_tear =
      0;  ///< of neighbours: |turn - turn'| beyond what their rotations differ [rad]; a full turn where a ring closes wrongly
};

/// A tree grows from the rotation with the least angle, always over the link whose two rotations differ least. Each node takes, of its
/// rotation vectors (whole turns added about its own axis), the one nearest to its parent's. Where none is near (close to whole turns there
/// is no axis) it copies its parent's; afterwards the copies are smoothed between their neighbours, and what is left goes to `remainders`.
///
/// @param neighbours  up to four of each node, -1 for none; symmetric
/// @param doubtful    1 for nodes to be reached last, as inverted tetrahedra
/// Source: after Gao et al., as-consistent-as-possible axis-angle, TVCG 2019, by a tree in place of a global solve. Deterministic.
LiftedTurns LiftTurns(const std::vector<Eigen::Matrix3d>& rotations, const std::vector<std::array<int, 4>>& neighbours,
                      const std::vector<char>& doubtful);

}  // namespace keypose::interpolation
