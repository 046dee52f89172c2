// The matching of two trees of limbs.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/values/mesh.h"
#include "register/skeleton/skeleton_tree.h"

namespace keypose::registration {

/// An assignment of the source's tips to the target's.
struct TipMatch {
  std::vector<std::pair<int, int>> pairs;  ///< joints of the source and of the target
  double cost = 0;
};

/// More data for MatchTreeTips.
struct TreeEvidence {
  double scale = 1;                             ///< target size over source size
  std::vector<int> source_nodes, target_nodes;  ///< skeleton nodes nearest to each landmark
  PointsX3 source_in_target;                    ///< nodes of the source, coarsely aligned
};

/// The `keep` assignments of tips with the lowest cost, best first. The cost is the difference in
/// distances along the skeletons (between tips and to landmarks), in thickness and, with a low
/// weight, in position after coarse alignment. All assignments are tried. Tips left over on one
/// side stay unmatched.
std::vector<TipMatch> MatchTreeTips(const SkeletonTree& source, const SkeletonTree& target,
                                    const TreeEvidence& evidence, int keep);

/// Gives both trees the same structure for a given assignment: removes unmatched tips, and merges
/// short limbs that only one of the trees has.
/// @return why that is impossible, or an empty string
std::string Reconcile(SkeletonTree& source, SkeletonTree& target, const TipMatch& match);

}  // namespace keypose::registration
