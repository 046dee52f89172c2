#include "armature/live/posed_puppet.h"

#include <algorithm>
#include <chrono>

#include "core/values/size_of.h"

namespace keypose::armature {

namespace {

double SecondsSince(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

PosedPuppet::PosedPuppet(const PuppetParts& parts)
    : matcher_(parts.armature, parts.plan, parts.skeleton, parts.world_from_armature,
               parts.options),
      skin_(parts.mesh.points, parts.weights, parts.skeleton.size()) {}

void PosedPuppet::Update(const std::vector<double>& values) {
  const auto begin = std::chrono::steady_clock::now();
  const SkeletonPose& pose = matcher_.Update(values);
  match_s_ = SecondsSince(begin);
  const auto skinning = std::chrono::steady_clock::now();
  if (matcher_.moved()) {
    skin_.Pose(pose.bones, &points_, MovedBones(pose.bones));
    last_bones_ = pose.bones;
  }
  skin_s_ = SecondsSince(skinning);
}

std::vector<char> PosedPuppet::MovedBones(const std::vector<Rigid3>& bones) const {
  if (last_bones_.empty()) return {};
  std::vector<char> moved(bones.size());
  for (std::size_t b = 0; b < bones.size(); ++b)
    moved[b] = bones[b].rotation.coeffs() != last_bones_[b].rotation.coeffs() ||
               bones[b].translation != last_bones_[b].translation;
  return moved;
}

std::vector<SkinBone> SkinBonesOf(const Skeleton& skeleton) {
  std::vector<SkinBone> bones;
  for (const SkeletonJoint& joint : skeleton.joints) {
    const Eigen::Vector3d head = joint.parent < 0 ? joint.rest : skeleton.joints[joint.parent].rest;
    bones.push_back({joint.name, head, joint.rest});
  }
  return bones;
}

std::vector<int> LeadingBones(const Skeleton& skeleton) {
  std::vector<int> leading(skeleton.size()), below(skeleton.size(), 0);
  for (int j = 0; j < skeleton.size(); ++j) leading[j] = j;
  for (int j = skeleton.size() - 1; j >= 0; --j) {
    const int parent = skeleton.joints[j].parent;
    if (parent < 0) continue;
    if (below[j] + 1 < below[parent]) continue;
    // Later joints come first here: of rows of one length the file's first stays.
    below[parent] = below[j] + 1;
    leading[parent] = j;
  }
  return leading;
}

}  // namespace keypose::armature
