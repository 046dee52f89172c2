// A curve skeleton as a tree of limbs and joints, and which limb of one pose is which of the other.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "core/ray_scene.h"
#include "register/skeleton/curve_skeleton.h"

namespace keypose::registration {

/// A run of skeleton nodes between two joints.
struct Limb {
  int from = -1, to = -1;  ///< joints
  std::vector<int> nodes;  ///< from the node at `from` to the node at `to`, both included
  double length = 0;
};

/// The end of a limb, or where limbs meet; may hold several nodes where close forks were merged.
struct Joint {
  std::vector<int> nodes;
  std::vector<int> limbs;
  double radius = 0;  ///< of the largest ball inside the surface around its nodes
  bool tip() const { return limbs.size() == 1; }
};

/// Where a node lies: on a limb, or (limb -1) in a joint.
struct NodePlace {
  int limb = -1, joint = -1;
  double arc = 0;  ///< from the limb's `from` end, along its nodes
};

class SkeletonTree {
 public:
  /// Prunes twigs that stay inside the body and merges forks that are closer together than the body
  /// is thick.
  SkeletonTree(const CurveSkeleton& skeleton, const RayScene& surface);

  const std::vector<Limb>& limbs() const { return limbs_; }
  const std::vector<Joint>& joints() const { return joints_; }
  const PointsX3& nodes() const { return nodes_; }
  const Eigen::VectorXd& radius() const {
    return radius_;
  }                               ///< of the largest ball inside the surface at each node
  std::vector<int> Tips() const;  ///< joints at the end of one limb
  double total_length() const;
  /// Distance along the skeleton from a tip to every node; pruned nodes count as the place where
  /// they were cut off.
  Eigen::VectorXd DistancesFrom(int joint) const;
  NodePlace PlaceOf(int node) const;
  /// Bits of the tips (numbered as `label` says, by joint) that lie beyond `limb`, seen from its
  /// `from` end.
  std::uint32_t TipsBeyond(int limb, const std::vector<int>& label) const;

  void DropTip(int joint);   ///< cuts the limb of that tip off
  void MergeLimb(int limb);  ///< makes one joint of its two ends and all between
  /// For a single limb: starts it in the middle of the ball at its thick end. False where there is
  /// none: where no place is `thicker` times as thick as the middle of the limb and within `reach`
  /// times that place's radius from an end.
  bool RootThickEnd(const RayScene& surface, double thicker, double reach);

 private:
  void GrowIntoBalls(const CurveSkeleton& skeleton, const RayScene& surface);
  void Rebuild();
  void Prune();
  void MergeCloseForks();
  bool PruneOne();
  void Cut(const std::vector<int>& branch, int at);

  PointsX3 nodes_;
  Eigen::VectorXd radius_;
  std::vector<std::vector<int>> neighbors_;
  std::vector<int> alias_;   // where a cut node was cut off; itself otherwise
  std::vector<int> merged_;  // label of the group of nodes that form one joint, or -1
  int groups_ = 0;
  std::vector<Limb> limbs_;
  std::vector<Joint> joints_;
};

/// Which tip of the source is which of the target; joints of both trees.
struct TipMatch {
  std::vector<std::pair<int, int>> pairs;
  double cost = 0;
};

/// What else is known of a pair of tips or of points: see MatchTreeTips.
struct TreeEvidence {
  double scale = 1;                             ///< target size over source size
  std::vector<int> source_nodes, target_nodes;  ///< skeleton nodes nearest to each landmark
  PointsX3 source_in_target;                    ///< nodes of the source, coarsely aligned
};

/// The `keep` assignments of tips with the least disagreement in distances along the skeletons
/// (among tips and to landmarks), in thickness, and, weakly, in place after coarse alignment, best
/// first. All assignments are tried; tips that are left over on one side stay unmatched.
std::vector<TipMatch> MatchTreeTips(const SkeletonTree& source, const SkeletonTree& target,
                                    const TreeEvidence& evidence, int keep);

/// Makes both trees branch alike, given the tips: cuts unmatched tips off and merges short limbs
/// that only one of them has.
/// @return why that is impossible, or nothing
std::string Reconcile(SkeletonTree& source, SkeletonTree& target, const TipMatch& match);

}  // namespace keypose::registration
