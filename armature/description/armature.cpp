#include "armature/description/armature.h"

#include <algorithm>

namespace keypose::armature {

int Armature::Find(const std::string& name) const {
  for (std::size_t n = 0; n < nodes.size(); ++n)
    if (nodes[n].name == name) return static_cast<int>(n);
  return -1;
}

int Armature::JointOf(int node) const {
  const auto found = std::lower_bound(joints.begin(), joints.end(), node);
  if (found == joints.end() || *found != node) return -1;
  return static_cast<int>(found - joints.begin());
}

int Armature::JointOfSensor(int sensor) const {
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (nodes[static_cast<std::size_t>(joints[j])].sensor == sensor) return static_cast<int>(j);
  return -1;
}

int Armature::sensor_count() const {
  int count = 0;
  for (const int node : joints)
    count = std::max(count, nodes[static_cast<std::size_t>(node)].sensor + 1);
  return count;
}

void ForwardKinematics(const Armature& armature, const std::vector<double>& values,
                       std::vector<Rigid3>* frames) {
  frames->resize(armature.nodes.size());
  std::size_t next_value = 0;
  for (std::size_t n = 0; n < armature.nodes.size(); ++n) {
    const ArmatureNode& node = armature.nodes[n];
    Rigid3 parent_from_node;
    if (node.kind == NodeKind::kJoint)
      parent_from_node.rotation = Eigen::AngleAxisd(values[next_value++], node.axis);
    else if (node.kind == NodeKind::kSlide)
      parent_from_node.translation = values[next_value++] * node.axis;
    else if (node.kind == NodeKind::kRod)
      parent_from_node.translation = node.length * node.axis;
    Rigid3& frame = (*frames)[n];
    frame = node.parent < 0
                ? parent_from_node
                : Compose((*frames)[static_cast<std::size_t>(node.parent)], parent_from_node);
    frame.rotation.normalize();  // else rounding would add up along a deep tree
  }
}

std::vector<Rigid3> ForwardKinematics(const Armature& armature, const std::vector<double>& values) {
  std::vector<Rigid3> frames;
  ForwardKinematics(armature, values, &frames);
  return frames;
}

std::vector<int> PathBetween(const Armature& armature, int from, int to) {
  std::vector<int> up, down;
  // Parents have smaller indices, so the larger of both ends is never the common ancestor.
  while (from != to) {
    int& deeper = from > to ? from : to;
    (from > to ? up : down).push_back(deeper);
    deeper = armature.nodes[static_cast<std::size_t>(deeper)].parent;
    if (deeper < 0) return {};
  }
  up.push_back(from);
  up.insert(up.end(), down.rbegin(), down.rend());
  return up;
}

int ChainPlan::FindAnchor(const std::string& name) const {
  for (std::size_t a = 0; a < anchors.size(); ++a)
    if (anchors[a].name == name) return static_cast<int>(a);
  return -1;
}

std::vector<std::vector<int>> ChainsMovedBy(const Armature& armature, const ChainPlan& plan) {
  std::vector<std::vector<int>> moved(armature.joints.size());
  for (std::size_t c = 0; c < plan.chains.size(); ++c) {
    std::vector<bool> marked(armature.nodes.size());
    for (int node : plan.chains[c].nodes)
      for (; node >= 0 && !marked[static_cast<std::size_t>(node)];
           node = armature.nodes[static_cast<std::size_t>(node)].parent)
        marked[static_cast<std::size_t>(node)] = true;
    for (std::size_t j = 0; j < armature.joints.size(); ++j)
      if (marked[static_cast<std::size_t>(armature.joints[j])])
        moved[j].push_back(static_cast<int>(c));
  }
  return moved;
}

}  // namespace keypose::armature
