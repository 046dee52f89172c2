#include "motion/bvh_rig/retarget.h"

#include <gtest/gtest.h>

#include "core/numbers/rotations.h"
#include "core/values/angles.h"
#include "motion/bvh_rig/joint_names.h"
#include "motion/bvh_rig/rigged_mesh.h"
#include "motion/bvh_rig/testing/rigged_body.h"

namespace keypose::motion::retarget_test {

Eigen::Vector3d HeadOf(const RiggedMesh& rig, const std::vector<BoneMove>& moves,
                       const char* name) {
  return moves[rig.Find(name)].head;
}

TEST(Retarget, HangingArmsTakeTheClipsLevelOnes) {
  const MotionClip clip = MakeClip(1, 1);
  const RiggedMesh rig = MakeBody();
  const std::vector<int> joints = MatchJoints(clip, rig, {});
  const std::vector<BoneMove> moves = Retarget(clip, rig, joints, {}).At(0);
  EXPECT_LT((HeadOf(rig, moves, "wrist.L") - Eigen::Vector3d(0.8, 1.3, 0)).norm(), 1e-12);
  EXPECT_LT((HeadOf(rig, moves, "wrist.R") - Eigen::Vector3d(-0.8, 1.3, 0)).norm(), 1e-12);
  EXPECT_LT((HeadOf(rig, moves, "foot.L") - Eigen::Vector3d(0.1, 0, 0)).norm(), 1e-12);
}

TEST(Retarget, ElbowBendsAndThePathIsScaledByTheLegs) {
  MotionClip clip = MakeClip(20, 2);  // another unit
  int column = 0;
  for (const ClipJoint& joint : clip.joints) {
    if (joint.name == "LeftForeArm") clip.values(1, column + 2) = 90;
    column += static_cast<int>(joint.channels.size());
  }
  clip.values(1, 2) = 10;  // z
  const RiggedMesh rig = MakeBody();
  const Retarget retarget(clip, rig, MatchJoints(clip, rig, {}), {});
  EXPECT_NEAR(retarget.scale(), 1 / 20.0, 1e-12);
  const std::vector<BoneMove> moves = retarget.At(1);
  EXPECT_LT((HeadOf(rig, moves, "wrist.L") - Eigen::Vector3d(0.5, 1.6, 0.5)).norm(), 1e-12);
  EXPECT_LT((HeadOf(rig, moves, "root") - Eigen::Vector3d(0, 0.8, 0.5)).norm(), 1e-12);
}

TEST(Retarget, ClipThatFacesTheOtherWayIsTurned) {
  MotionClip clip = MakeClip(1, 1);
  for (ClipJoint& joint : clip.joints) joint.offset[0] = -joint.offset[0];
  clip.values(0, 2) = 1;
  const RiggedMesh rig = MakeBody();
  const std::vector<BoneMove> moves = Retarget(clip, rig, MatchJoints(clip, rig, {}), {}).At(0);
  EXPECT_LT((HeadOf(rig, moves, "wrist.L") - Eigen::Vector3d(0.8, 1.3, -1)).norm(), 1e-12);
}

TEST(Retarget, BetweenTwoFramesThePoseIsBetween) {
  MotionClip clip = MakeClip(1, 2);
  clip.values(1, 1) = 0.2;  // y
  clip.values(1, 3 + 1) = 40;
  const RiggedMesh rig = MakeBody();
  const Retarget retarget(clip, rig, MatchJoints(clip, rig, {}), {});
  const Eigen::Vector3d half =
      Eigen::Vector3d(0, 0.9, 0) + ExpOf({0, 20 * kDegree, 0}) * Eigen::Vector3d(0.8, 0.5, 0);
  EXPECT_LT((HeadOf(rig, retarget.At(0.5), "wrist.L") - half).norm(), 1e-12);
  EXPECT_LT((HeadOf(rig, retarget.At(1.0), "root") - Eigen::Vector3d(0, 1, 0)).norm(), 1e-12);
}

TEST(Retarget, ClipWithZUpMovesARigWithYUp) {
  MotionClip clip = MakeClip(1, 2);
  // x stays, y becomes z, and z, the front, becomes -y.
  for (ClipJoint& joint : clip.joints)
    joint.offset = Eigen::Vector3d(joint.offset[0], -joint.offset[2], joint.offset[1]);
  clip.values(1, 1) = -1;  // a step forwards
  const RiggedMesh rig = MakeBody();
  const std::vector<int> joints = MatchJoints(clip, rig, {});
  const RestUps ups = UpsAtRest(clip, rig, joints);
  EXPECT_TRUE(ups.clip.upright && ups.rig.upright);
  EXPECT_EQ(ups.clip.axis, 2);
  EXPECT_EQ(ups.rig.axis, 1);
  const std::vector<BoneMove> moves =
      Retarget(clip, rig, joints, {ups.clip.axis, ups.rig.axis}).At(1);
  EXPECT_LT((HeadOf(rig, moves, "wrist.L") - Eigen::Vector3d(0.8, 1.3, 1)).norm(), 1e-12);
  EXPECT_LT((HeadOf(rig, moves, "foot.R") - Eigen::Vector3d(-0.1, 0, 1)).norm(), 1e-12);
}

TEST(UpsAtRest, BodyThatLiesIsNotUpright) {
  MotionClip clip = MakeClip(1, 1);
  for (ClipJoint& joint : clip.joints)
    joint.offset = Eigen::Vector3d(joint.offset[1], joint.offset[0], 0);
  const RiggedMesh rig = MakeBody();
  const RestUp up = UpsAtRest(clip, rig, MatchJoints(clip, rig, {})).clip;
  EXPECT_TRUE(up.has_legs);
  EXPECT_FALSE(up.upright);
  EXPECT_EQ(up.axis, 1);
}

TEST(BeginsWithItsRest, OnlyWhenTheSecondFrameMoves) {
  MotionClip clip = MakeClip(1, 2);
  clip.values.row(0).head<3>() << 0, 90, 0;  // a place is no pose
  EXPECT_FALSE(BeginsWithItsRest(clip));
  clip.values(1, 8) = 60;
  EXPECT_TRUE(BeginsWithItsRest(clip));
  clip.values(0, 8) = 50;
  EXPECT_FALSE(BeginsWithItsRest(clip));
}

}  // namespace keypose::motion::retarget_test
