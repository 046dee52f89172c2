#include "armature/matching/joint_skeleton.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include "armature/matching/puppet_match.h"
#include "armature/matching/testing/spines.h"
#include "core/values/errors.h"

namespace keypose::armature::joint_skeleton_test {

using Eigen::Vector3d;

TEST(Skeleton, ClipGivesNamedJointsWithZUp) {
  MotionClip clip;
  clip.joints = {
      {"hips", -1, {0, 1, 0}, {}}, {"spine", 0, {0, 0.5, 0.1}, {}}, {"", 1, {0, 1, 0}, {}}};
  const Skeleton skeleton = SkeletonOfClip(clip, true);
  EXPECT_EQ(skeleton.joints[2].name, "spine_end");
  EXPECT_LT((skeleton.joints[2].rest - Vector3d(0, -0.1, 2.5)).norm(), 1e-15);
  clip.joints[1].name = "hips";
  EXPECT_THROW(SkeletonOfClip(clip, true), InputError);
  EXPECT_THROW(SkeletonOfClip({}, true), InputError);
}

TEST(Skeleton, ArmatureGivesASkeletonThatFollowsIt) {
  const Spine spine = MakeSpine({1, 2, 1.5});
  const auto frames = ForwardKinematics(spine.armature, {0, 0, 0});
  const Skeleton skeleton = SkeletonOfArmature(spine.armature, spine.plan, frames);
  ASSERT_EQ(skeleton.size(), 4);
  EXPECT_EQ(skeleton.joints[0].name, "near");
  EXPECT_EQ(skeleton.joints[3].name, "far");
  PuppetMatcher matcher(spine.armature, spine.plan, skeleton, {}, {});
  const SkeletonPose& pose = matcher.Update({0.3, -0.4, 0.2});
  const auto posed = ForwardKinematics(spine.armature, {0.3, -0.4, 0.2});
  EXPECT_LT((pose.joints.row(3).transpose() - posed.back().translation).norm(), 1e-12);
}

}  // namespace keypose::armature::joint_skeleton_test
