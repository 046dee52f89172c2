#include "motion/bvh_rig/retarget.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "motion/bvh_rig/joint_names.h"

namespace keypose::motion {

namespace {

using enum BodyJoint;

constexpr double kUpright = 0.8;  // cosine: legs that point within 37 degrees of an axis

/// Joints of the clip at rest, with all angles and positions zero.
std::vector<Eigen::Vector3d> RestOf(const MotionClip& clip) {
  std::vector<Eigen::Vector3d> rest;
  for (const ClipJoint& joint : clip.joints)
    rest.push_back(joint.parent < 0 ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                                    : Eigen::Vector3d(rest[joint.parent] + joint.offset));
  return rest;
}

/// Bones and joints of a body's limbs, by what they mean.
struct Limbs {
  std::map<BodyJoint, int> bone;
  const RiggedMesh* rig;
  const std::vector<int>* joints;
  const std::vector<Eigen::Vector3d>* rest;

  bool Has(BodyJoint joint) const { return bone.count(joint) > 0; }
  Eigen::Vector3d OnRig(BodyJoint joint) const { return rig->bones[bone.at(joint)].head; }
  Eigen::Vector3d OnClip(BodyJoint joint) const { return (*rest)[(*joints)[bone.at(joint)]]; }
};

/// By the rig's own names or, where these say nothing, by those of the joints that move them.
Limbs LimbsOf(const MotionClip& clip, const RiggedMesh& rig, const std::vector<int>& joints,
              const std::vector<Eigen::Vector3d>& rest) {
  std::vector<std::string> bone_names, joint_names;
  for (int b = 0; b < SizeOf(rig.bones); ++b) {
    bone_names.push_back(rig.bones[b].name);
    joint_names.push_back(joints[b] >= 0 ? clip.joints[joints[b]].name : "");
  }
  const std::vector<BodyJoint> by_bone = MeaningOf(bone_names), by_joint = MeaningOf(joint_names);
  Limbs limbs{{}, &rig, &joints, &rest};
  for (int b = 0; b < SizeOf(rig.bones); ++b) {
    const BodyJoint meaning = by_bone[b] != kNone ? by_bone[b] : by_joint[b];
    if (joints[b] >= 0 && meaning != kNone) limbs.bone.try_emplace(meaning, b);
  }
  return limbs;
}

/// Against where the legs point; a body that lies, or stands on its head, is not upright.
RestUp UpOfLegs(const Limbs& limbs, bool on_clip) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& [thigh, shin] : {std::pair(kThighL, kShinL), std::pair(kThighR, kShinR)})
    if (limbs.Has(thigh) && limbs.Has(shin))
      sum += on_clip ? limbs.OnClip(thigh) - limbs.OnClip(shin)
                     : limbs.OnRig(thigh) - limbs.OnRig(shin);
  RestUp up;
  up.has_legs = sum.norm() > 0;
  int axis = 0;
  if (up.has_legs && sum.maxCoeff(&axis) > kUpright * sum.norm() && axis > 0) {
    up.axis = axis;
    up.upright = true;
  }
  return up;
}

double LegOf(const Limbs& limbs, bool on_clip) {
  double length = 0;
  for (const auto& [thigh, shin, foot] :
       {std::array{kThighL, kShinL, kFootL}, std::array{kThighR, kShinR, kFootR}}) {
    if (!limbs.Has(thigh) || !limbs.Has(shin) || !limbs.Has(foot)) continue;
    const auto at = [&](BodyJoint j) { return on_clip ? limbs.OnClip(j) : limbs.OnRig(j); };
    length += (at(thigh) - at(shin)).norm() + (at(shin) - at(foot)).norm();
  }
  return length;
}

/// Joints at a moment between two frames of the clip.
std::vector<Rigid3> FramesBetween(const MotionClip& clip, double frame) {
  const int before = static_cast<int>(std::floor(frame));
  std::vector<Rigid3> joints = JointFrames(clip, before);
  const double share = frame - before;
  if (share == 0) return joints;
  const std::vector<Rigid3> after = JointFrames(clip, before + 1);
  for (int j = 0; j < SizeOf(joints); ++j) {
    joints[j].rotation = joints[j].rotation.slerp(share, after[j].rotation);
    joints[j].translation += share * (after[j].translation - joints[j].translation);
  }
  return joints;
}

double Size(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d low = points[0], high = points[0];
  for (const Eigen::Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).norm();
}

}  // namespace

RestUps UpsAtRest(const MotionClip& clip, const RiggedMesh& rig, const std::vector<int>& joints) {
  const std::vector<Eigen::Vector3d> rest = RestOf(clip);
  const Limbs limbs = LimbsOf(clip, rig, joints, rest);
  return {UpOfLegs(limbs, true), UpOfLegs(limbs, false)};
}

bool BeginsWithItsRest(const MotionClip& clip) {
  constexpr double kStill = 5, kMoved = 20;  // degrees
  if (clip.frame_count() < 2) return false;
  double first = 0, second = 0;
  int column = 0;
  for (const ClipJoint& joint : clip.joints)
    for (const BvhChannel channel : joint.channels) {
      if (channel >= BvhChannel::kXrotation) {
        first = std::max(first, std::abs(std::remainder(clip.values(0, column), 360)));
        second = std::max(second, std::abs(std::remainder(clip.values(1, column), 360)));
      }
      ++column;
    }
  return first < kStill && second > kMoved;
}

Retarget::Retarget(const MotionClip& clip, const RiggedMesh& rig, const std::vector<int>& joints,
                   UpAxes up)
    : clip_(clip),
      rig_(rig),
      joints_(joints),
      to_clip_rest_(rig.bones.size(), Eigen::Matrix3d::Identity()) {
  const std::vector<Eigen::Vector3d> rest = RestOf(clip);
  const Limbs limbs = LimbsOf(clip, rig, joints, rest);
  const Eigen::Vector3d up_axis = Eigen::Vector3d::Unit(up.rig);
  // From z up to y up, what looks along -y then looks along z; and back.
  if (up.clip != up.rig)
    rig_from_clip_ = Eigen::AngleAxisd((up.rig == 1 ? -0.5 : 0.5) * kPi, Eigen::Vector3d::UnitX())
                         .toRotationMatrix();
  if (limbs.Has(kThighL) && limbs.Has(kThighR)) {
    const auto level = [&](const Eigen::Vector3d& v) {
      return (v - v.dot(up_axis) * up_axis).eval();
    };
    const Eigen::Vector3d from = level(rig_from_clip_ *
                                       (limbs.OnClip(kThighL) - limbs.OnClip(kThighR))),
                          to = level(limbs.OnRig(kThighL) - limbs.OnRig(kThighR));
    if (from.norm() > 0 && to.norm() > 0)
      rig_from_clip_ =
          Eigen::AngleAxisd(std::atan2(from.cross(to).dot(up_axis), from.dot(to)), up_axis)
              .toRotationMatrix() *
          rig_from_clip_;
  }
  for (const auto& [begin, end] :
       {std::pair(kUpperArmL, kForearmL), std::pair(kForearmL, kHandL), std::pair(kThighL, kShinL),
        std::pair(kShinL, kFootL), std::pair(kUpperArmR, kForearmR), std::pair(kForearmR, kHandR),
        std::pair(kThighR, kShinR), std::pair(kShinR, kFootR)}) {
    if (!limbs.Has(begin) || !limbs.Has(end)) continue;
    const Eigen::Vector3d own = limbs.OnRig(end) - limbs.OnRig(begin),
                          clips = rig_from_clip_ * (limbs.OnClip(end) - limbs.OnClip(begin));
    if (own.norm() > 0 && clips.norm() > 0)
      to_clip_rest_[limbs.bone.at(begin)] =
          Eigen::Quaterniond::FromTwoVectors(own, clips).toRotationMatrix();
  }
  // A hand goes with its forearm; a foot is flat in both rest poses.
  for (const auto& [forearm, hand] : {std::pair(kForearmL, kHandL), std::pair(kForearmR, kHandR)})
    if (limbs.Has(forearm) && limbs.Has(hand))
      to_clip_rest_[limbs.bone.at(hand)] = to_clip_rest_[limbs.bone.at(forearm)];
  const double clip_leg = LegOf(limbs, true), rig_leg = LegOf(limbs, false);
  std::vector<Eigen::Vector3d> heads;
  for (const Bone& bone : rig.bones) heads.push_back(bone.head);
  const double clip_size = Size(rest);
  scale_ = clip_size > 0 ? Size(heads) / clip_size : 1;
  if (clip_leg > 0 && rig_leg > 0) scale_ = rig_leg / clip_leg;
  for (int b = 0; b < SizeOf(rig.bones); ++b)
    if (joints_[b] >= 0) {
      root_bone_ = b;
      root_joint_ = joints_[b];
      break;
    }
  clip_rest_ = rest[root_joint_];
}

std::vector<BoneMove> Retarget::At(double frame) const {
  const std::vector<Rigid3> joints = FramesBetween(clip_, frame);
  std::vector<BoneMove> moves(rig_.bones.size());
  for (int b = 0; b < SizeOf(moves); ++b) {
    const Bone& bone = rig_.bones[b];
    const int parent = bone.parent;
    if (joints_[b] >= 0)
      moves[b].turn = rig_from_clip_ * joints[joints_[b]].rotation.toRotationMatrix() *
                      rig_from_clip_.transpose() * to_clip_rest_[b];
    else if (parent >= 0)
      moves[b].turn = moves[parent].turn;
    moves[b].head =
        parent >= 0
            ? (moves[parent].head + moves[parent].turn * (bone.head - rig_.bones[parent].head))
                  .eval()
            : bone.head;
  }
  const Eigen::Vector3d wanted =
      rig_.bones[root_bone_].head +
      scale_ * (rig_from_clip_ * (joints[root_joint_].translation - clip_rest_));
  const Eigen::Vector3d shift = wanted - moves[root_bone_].head;
  for (BoneMove& move : moves) move.head += shift;
  return moves;
}

}  // namespace keypose::motion
