#include "armature/matching/joint_skeleton.h"

#include <map>
#include <set>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature {

using Eigen::Vector3d;

int Skeleton::Find(const std::string& name) const {
  for (int j = 0; j < size(); ++j)
    if (joints[j].name == name) return j;
  return -1;
}

std::vector<int> Skeleton::PathBetween(int from, int to) const {
  std::vector<int> up, down;
  // Parents have smaller indices, so the larger of both ends is never the common ancestor.
  while (from != to) {
    int& deeper = from > to ? from : to;
    (from > to ? up : down).push_back(deeper);
    deeper = joints[deeper].parent;
    if (deeper < 0) return {};
  }
  up.push_back(from);
  up.insert(up.end(), down.rbegin(), down.rend());
  return up;
}

Skeleton SkeletonOfClip(const MotionClip& clip, bool y_up) {
  if (clip.joints.empty()) throw InputError("armature: the skeleton has no joints");
  Skeleton skeleton;
  std::set<std::string> names;
  for (const ClipJoint& joint : clip.joints) {
    SkeletonJoint made;
    made.parent = joint.parent;
    const bool root = joint.parent < 0;
    made.name = joint.name;
    if (made.name.empty()) made.name = root ? "root" : skeleton.joints[joint.parent].name + "_end";
    const Vector3d& o = joint.offset;
    made.rest = y_up ? Vector3d(o.x(), -o.z(), o.y()) : o;
    if (!root) made.rest += skeleton.joints[joint.parent].rest;
    if (!names.insert(made.name).second)
      throw InputError("armature: two joints of the skeleton are named '" + made.name +
                       "'; chains name joints, so give each a name of its own");
    skeleton.joints.push_back(made);
  }
  return skeleton;
}

namespace {

/// Adds the places of one chain that the skeleton does not have yet.
class ChainJoints {
 public:
  ChainJoints(const ChainPlan& plan, const std::vector<Rigid3>& frames, Skeleton* skeleton)
      : plan_(plan), frames_(frames), skeleton_(*skeleton) {}

  void Add(const Armature& armature, const Chain& chain) {
    const int first = chain.nodes.front();
    int at = JointOf(plan_.anchors[chain.from].computer, JointAbove(armature, first), first);
    for (int n = 1; n + 1 < SizeOf(chain.nodes); ++n) {
      const int node = chain.nodes[n];
      if ((Place(node) - Place(chain.nodes.back())).norm() <= kSamePlace) break;
      if ((Place(node) - skeleton_.joints[at].rest).norm() > kSamePlace)
        at = JointOf(NameOf(armature, node), at, node);
      joint_of_[node] = at;
    }
    JointOf(plan_.anchors[chain.to].computer, at, chain.nodes.back());
  }

 private:
  static constexpr double kSamePlace = 1e-12;

  Vector3d Place(int node) const { return frames_[node].translation; }

  std::string NameOf(const Armature& armature, int node) const {
    const std::string& name = armature.nodes[node].name;
    return name.empty() ? "node" + std::to_string(node) : name;
  }

  /// The joint on which a chain hangs that begins at no other chain's end: that of the nearest node
  /// above; -1: none.
  int JointAbove(const Armature& armature, int node) const {
    for (; node >= 0; node = armature.nodes[node].parent)
      if (const auto known = joint_of_.find(node); known != joint_of_.end()) return known->second;
    return -1;
  }

  int JointOf(const std::string& name, int parent, int node) {
    int joint = skeleton_.Find(name);
    if (joint < 0) {
      skeleton_.joints.push_back({name, parent, Place(node)});
      joint = skeleton_.size() - 1;
    }
    joint_of_[node] = joint;
    return joint;
  }

  std::map<int, int> joint_of_;  ///< of nodes that are part of the skeleton
  const ChainPlan& plan_;
  const std::vector<Rigid3>& frames_;
  Skeleton& skeleton_;
};

}  // namespace

Skeleton SkeletonOfArmature(const Armature& armature, const ChainPlan& plan,
                            const std::vector<Rigid3>& frames) {
  if (plan.chains.empty())
    throw InputError("armature: a skeleton like the armature needs a chain; the file has none");
  Skeleton skeleton;
  ChainJoints joints(plan, frames, &skeleton);
  for (const Chain& chain : plan.chains) joints.Add(armature, chain);
  return skeleton;
}

}  // namespace keypose::armature
