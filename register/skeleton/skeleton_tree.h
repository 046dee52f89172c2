// A curve skeleton as a tree of limbs and joints.
#pragma once

#include <cstdint>
#include <vector>

#include "core/surfaces/ray_scene.h"
#include "core/values/mesh.h"
#include "register/skeleton/curve_skeleton.h"

namespace keypose::registration {

/// A chain of skeleton nodes between two joints.
struct Limb {
  int from = -1, to = -1;  ///< joints
  std::vector<int> nodes;  ///< from the node at `from` to the node at `to`, both included
  double length = 0;
};

/// The end of a limb, or the place where limbs meet. It has several nodes where close forks were
/// merged.
struct Joint {
  std::vector<int> nodes;
  std::vector<int> limbs;
  double radius = 0;  ///< of the largest ball around one of its nodes that is inside the surface
  bool tip() const { return limbs.size() == 1; }
};

/// The place of a node: on a limb, or in a joint (then limb is -1).
struct NodePlace {
  int limb = -1, joint = -1;
  double arc = 0;  ///< from the limb's `from` end, along its nodes
};

/// A tree of limbs and joints.
class SkeletonTree {
 public:
  /// Builds the tree. Removes short branches that stay inside the body, and merges forks that are
  /// closer together than the body is thick.
  SkeletonTree(const CurveSkeleton& skeleton, const RayScene& surface);

  const std::vector<Limb>& limbs() const { return limbs_; }
  const std::vector<Joint>& joints() const { return joints_; }
  const PointsX3& nodes() const { return nodes_; }
  const Eigen::VectorXd& radius() const {
    return radius_;
  }                               ///< of the largest ball inside the surface at each node
  std::vector<int> Tips() const;  ///< joints at the end of one limb
  double total_length() const;
  /// Distance along the skeleton from a tip to every node. A pruned node has the distance of the
  /// node where it was cut off.
  Eigen::VectorXd DistancesFrom(int joint) const;
  NodePlace PlaceOf(int node) const;
  /// The tips beyond `limb`, seen from its `from` end, as a set of bits. label[joint] is the tip's
  /// bit number.
  std::uint32_t TipsBeyond(int limb, const std::vector<int>& label) const;

  void DropTip(int joint);   ///< removes the limb of that tip
  void MergeLimb(int limb);  ///< merges the limb and its two ends into one joint
  /// For a tree with a single limb: moves its start to the centre of the ball at its thick end.
  /// @param thicker  least radius of the ball, over the median radius of the limb
  /// @param reach    largest distance of the ball from an end, over the ball's radius
  /// @return false when there is no such ball
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
  std::vector<int> alias_;   // the node where a removed node was cut off; itself otherwise
  std::vector<int> merged_;  // label of the group of nodes that form one joint, or -1
  int groups_ = 0;
  std::vector<Limb> limbs_;
  std::vector<Joint> joints_;
};

}  // namespace keypose::registration
