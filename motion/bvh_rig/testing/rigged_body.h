// A body of sticks and a clip that moves it.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/values/motion_clip.h"
#include "motion/bvh_rig/rigged_mesh.h"

namespace keypose::motion {

inline const std::vector<BvhChannel> kTurns = {BvhChannel::kXrotation, BvhChannel::kYrotation,
                                               BvhChannel::kZrotation};

/// A clip of a body of given size: hips, two legs, two arms; y up, arms level.
inline MotionClip MakeClip(double size, int frames) {
  MotionClip clip;
  const auto add = [&](const std::string& name, int parent, double x, double y) {
    clip.joints.push_back({name, parent, size * Eigen::Vector3d(x, y, 0), kTurns});
    return static_cast<int>(clip.joints.size()) - 1;
  };
  add("Hips", -1, 0, 0);
  clip.joints[0].channels = {BvhChannel::kXposition, BvhChannel::kYposition,
                             BvhChannel::kZposition, BvhChannel::kXrotation,
                             BvhChannel::kYrotation, BvhChannel::kZrotation};
  for (const auto& [side, sign] : {std::pair("Left", 1.0), std::pair("Right", -1.0)}) {
    const std::string s = side;
    const int thigh = add(s + "UpLeg", 0, 0.1 * sign, 0), shin = add(s + "Leg", thigh, 0, -0.4);
    add(s + "Foot", shin, 0, -0.4);
    const int arm = add(s + "Arm", 0, 0.2 * sign, 0.5),
              fore = add(s + "ForeArm", arm, 0.3 * sign, 0);
    add(s + "Hand", fore, 0.3 * sign, 0);
  }
  clip.values.setZero(frames, clip.channel_count());
  return clip;
}

/// A rig of the same body with hanging arms; its mesh has a small triangle at each bone's head.
inline RiggedMesh MakeBody() {
  RiggedMesh rig;
  const auto add = [&](const std::string& name, int parent, double x, double y) {
    rig.bones.push_back({name, parent, {x, y, 0}, {x, y - 0.1, 0}});
    return static_cast<int>(rig.bones.size()) - 1;
  };
  add("root", -1, 0, 0.8);
  for (const auto& [side, sign] : {std::pair(".L", 1.0), std::pair(".R", -1.0)}) {
    const std::string s = side;
    const int thigh = add("upperleg01" + s, 0, 0.1 * sign, 0.8),
              shin = add("lowerleg01" + s, thigh, 0.1 * sign, 0.4);
    add("foot" + s, shin, 0.1 * sign, 0);
    const int arm = add("upperarm01" + s, 0, 0.2 * sign, 1.3),
              fore = add("lowerarm01" + s, arm, 0.2 * sign, 1.0);
    add("wrist" + s, fore, 0.2 * sign, 0.7);
  }
  const int count = static_cast<int>(rig.bones.size());
  rig.mesh.points.resize(3 * count, 3);
  rig.mesh.faces.resize(count, 3);
  for (int b = 0; b < count; ++b) {
    for (int k = 0; k < 3; ++k) {
      rig.mesh.points.row(3 * b + k) = rig.bones[b].head.transpose();
      rig.mesh.points(3 * b + k, k) += 0.01;
      rig.weights.push_back({{b, 1.0}});
    }
    rig.mesh.faces.row(b) << 3 * b, 3 * b + 1, 3 * b + 2;
  }
  return rig;
}

}  // namespace keypose::motion
