#include "armature/live/pose_text.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <Eigen/Geometry>
#include "armature/live/posed_puppet.h"
#include "armature/live/testing/theropod_parts.h"
#include "armature/testing/theropods.h"

namespace keypose::armature::pose_text_test {

using Eigen::Vector3d;

TEST(Skeleton, TheropodsOwnIsOneTreeThatFollowsToTheBit) {
  PuppetParts parts = TheropodParts();
  for (Chain& chain : parts.plan.chains) chain.computer.clear();
  const std::vector<double> zero(parts.armature.joints.size(), 0);
  parts.skeleton =
      SkeletonOfArmature(parts.armature, parts.plan, ForwardKinematics(parts.armature, zero));
  parts.world_from_armature = {};
  int roots = 0;
  for (const SkeletonJoint& joint : parts.skeleton.joints) roots += joint.parent < 0;
  EXPECT_EQ(roots, 1);
  PuppetMatcher matcher(parts.armature, parts.plan, parts.skeleton, {}, {});
  const auto values = TheropodWalk(parts.armature, 0.4);
  const SkeletonPose& pose = matcher.Update(values);
  const auto frames = ForwardKinematics(parts.armature, values);
  for (const Anchor& anchor : parts.plan.anchors) {
    const Vector3d joint = pose.joints.row(parts.skeleton.Find(anchor.computer));
    EXPECT_LT((joint - frames[anchor.node].translation).norm(), 1e-9) << anchor.name;
  }
}

TEST(LeadingBones, GoOnAlongTheLongestRow) {
  const Skeleton skeleton = TheropodParts().skeleton;
  const auto leading = LeadingBones(skeleton);
  EXPECT_EQ(leading[skeleton.Find("Hips")], skeleton.Find("Tail1"));
  EXPECT_EQ(leading[skeleton.Find("Neck1")], skeleton.Find("Neck2"));
  EXPECT_EQ(leading[skeleton.Find("HeadTip")], skeleton.Find("HeadTip"));
}

TEST(SkeletonClip, JointsTurnAsTheBonesDo) {
  const PuppetParts parts = TheropodParts();
  PosedPuppet puppet(parts);
  std::vector<SkeletonPose> poses;
  for (int f = 0; f < 12; ++f) {
    puppet.Update(TheropodWalk(parts.armature, 0.1 * f));
    poses.push_back(puppet.matcher().pose());
  }
  const MotionClip clip = SkeletonClip(parts.skeleton, poses, 24);
  ASSERT_EQ(clip.frame_count(), 12);
  for (int f = 0; f < 12; ++f) {
    const auto frames = JointFrames(clip, f);
    for (const char* name : {"HeadTip", "TailTip"}) {
      const Vector3d place = poses[f].joints.row(parts.skeleton.Find(name));
      EXPECT_LT((frames[clip.Find(name)].translation - place).norm(), 1e-9) << name << f;
    }
    if (f > 0) {
      const double step = (clip.values.row(f) - clip.values.row(f - 1)).cwiseAbs().maxCoeff();
      EXPECT_LT(step, 60) << "angles do not jump by whole turns";
    }
  }
}

TEST(PoseJson, IsALineThatParses) {
  const PuppetParts parts = TheropodParts();
  PosedPuppet puppet(parts);
  puppet.Update(TheropodWalk(parts.armature, 0.2));
  const std::string line = PoseJson(parts.skeleton, puppet.matcher(), {1.5, 7, true, 0.002});
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const auto json = nlohmann::json::parse(line);
  EXPECT_EQ(json["pose"], 7);
  EXPECT_EQ(json["matched"], 6);
  EXPECT_EQ(json["joints"].size(), parts.skeleton.joints.size());
  const auto head = json["joints"]["HeadTip"];
  const int joint = parts.skeleton.Find("HeadTip");
  EXPECT_NEAR(head[1].get<double>(), puppet.matcher().pose().joints(joint, 1), 1e-5);
}

}  // namespace keypose::armature::pose_text_test
