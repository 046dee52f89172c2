// Assigns the limb tips of one pose to those of the other.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace keypose::registration {

/// What the assignment is computed from. Distances are along the surface, over the square root of
/// the area.
struct TipProblem {
  Eigen::MatrixXd source_distances, target_distances;  ///< S x S, T x T, between tips
  Eigen::MatrixXd unlike;  ///< S x T, 0 where two tips look the same, 1 where they do not
  int known = 0;           ///< the first `known` tips of both are matched in order, at any cost
};

struct TipAssignment {
  std::vector<int> target_of;  ///< S, a target tip or -1
  double score = 0;  ///< lower is better; each pair of assigned tips that agrees lowers it
};

/// The `keep` best assignments, best first, by branch and bound. Exact for up to `kMostSteps`
/// search nodes; beyond that, the best found so far. Deterministic.
std::vector<TipAssignment> MatchTips(const TipProblem& problem, int keep);

}  // namespace keypose::registration
