#include "core/values/motion_clip.h"

#include <algorithm>
#include <cmath>

#include "core/values/angles.h"

namespace keypose {
namespace {

Eigen::Vector3d AxisOf(BvhChannel channel) {
  return Eigen::Vector3d::Unit(static_cast<int>(channel) % 3);
}

bool Turns(BvhChannel channel) { return channel >= BvhChannel::kXrotation; }

}  // namespace

int MotionClip::channel_count() const {
  int count = 0;
  for (const ClipJoint& joint : joints) count += static_cast<int>(joint.channels.size());
  return count;
}

int MotionClip::Find(const std::string& name) const {
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (joints[j].name == name) return static_cast<int>(j);
  return -1;
}

std::vector<Rigid3> JointFrames(const MotionClip& clip, int frame) {
  std::vector<Rigid3> frames;
  int column = 0;
  for (const ClipJoint& joint : clip.joints) {
    // Position channels replace the offset, as in all programs that read BVH.
    Rigid3 parent_from_joint{Eigen::Quaterniond::Identity(), joint.offset};
    bool placed = false;
    for (const BvhChannel channel : joint.channels) {
      const double value = clip.values(frame, column++);
      if (Turns(channel)) {
        parent_from_joint.rotation =
            parent_from_joint.rotation *
            Eigen::Quaterniond(Eigen::AngleAxisd(value * kDegree, AxisOf(channel)));
      } else {
        if (!placed) parent_from_joint.translation.setZero();
        placed = true;
        parent_from_joint.translation += value * AxisOf(channel);
      }
    }
    parent_from_joint.rotation.normalize();
    frames.push_back(joint.parent < 0 ? parent_from_joint
                                      : Compose(frames[joint.parent], parent_from_joint));
  }
  return frames;
}

Eigen::Vector3d EulerZyx(const Eigen::Matrix3d& r) {
  const double y = std::asin(std::clamp(-r(2, 0), -1.0, 1.0));
  // At the pole only the sum of z and x is fixed: x is put to zero.
  if (std::abs(r(2, 0)) > 1 - 1e-12) return {std::atan2(-r(0, 1), r(1, 1)), y, 0};
  return {std::atan2(r(1, 0), r(0, 0)), y, std::atan2(r(2, 1), r(2, 2))};
}

}  // namespace keypose
