#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/angles.h"
#include "core/errors.h"
#include "core/rotations.h"
#include "core/testing_shapes.h"
#include "motion/bvh_rig/joint_names.h"
#include "motion/bvh_rig/retarget.h"
#include "motion/bvh_rig/rig.h"
#include "motion/bvh_rig/rig_text.h"

namespace keypose::motion {
namespace {

const std::vector<BvhChannel> kTurns = {BvhChannel::kXrotation, BvhChannel::kYrotation,
                                        BvhChannel::kZrotation};

/// A clip of a body of given size: hips, two legs, two arms; y up, arms level.
MotionClip MakeClip(double size, int frames) {
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
Rig MakeBody() {
  Rig rig;
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

Eigen::Vector3d HeadOf(const Rig& rig, const std::vector<BoneMove>& moves, const char* name) {
  return moves[rig.Find(name)].head;
}

TEST(Retarget, HangingArmsTakeTheClipsLevelOnes) {
  const MotionClip clip = MakeClip(1, 1);
  const Rig rig = MakeBody();
  const std::vector<int> joints = MatchJoints(clip, rig, {});
  const std::vector<BoneMove> moves = Retarget(clip, rig, joints, 1).At(0);
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
  const Rig rig = MakeBody();
  const Retarget retarget(clip, rig, MatchJoints(clip, rig, {}), 1);
  EXPECT_NEAR(retarget.scale(), 1 / 20.0, 1e-12);
  const std::vector<BoneMove> moves = retarget.At(1);
  EXPECT_LT((HeadOf(rig, moves, "wrist.L") - Eigen::Vector3d(0.5, 1.6, 0.5)).norm(), 1e-12);
  EXPECT_LT((HeadOf(rig, moves, "root") - Eigen::Vector3d(0, 0.8, 0.5)).norm(), 1e-12);
}

TEST(Retarget, ClipThatFacesTheOtherWayIsTurned) {
  MotionClip clip = MakeClip(1, 1);
  for (ClipJoint& joint : clip.joints) joint.offset[0] = -joint.offset[0];
  clip.values(0, 2) = 1;
  const Rig rig = MakeBody();
  const std::vector<BoneMove> moves = Retarget(clip, rig, MatchJoints(clip, rig, {}), 1).At(0);
  EXPECT_LT((HeadOf(rig, moves, "wrist.L") - Eigen::Vector3d(0.8, 1.3, -1)).norm(), 1e-12);
}

TEST(Skinned, BoneTurnsItsVerticesAboutItsHead) {
  const Rig rig = MakeBody();
  std::vector<BoneMove> moves;
  const Eigen::Matrix3d turn = ExpOf({0.3, 1, -0.2});
  for (const Bone& bone : rig.bones) moves.push_back({turn, turn * bone.head});
  const PointsX3 points = Skinned(rig, moves);
  EXPECT_LT((points - rig.mesh.points * turn.transpose()).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(MeaningOf, KnowsTheUsualNames) {
  using enum BodyJoint;
  const auto one = [](const std::string& name) { return MeaningOf({name})[0]; };
  EXPECT_EQ(one("mixamorig:LeftForeArm"), kForearmL);
  EXPECT_EQ(one("upperleg01.R"), kThighR);
  EXPECT_EQ(one("LoArm_L"), kForearmL);
  EXPECT_EQ(one("RightHip"), kThighR);
  EXPECT_EQ(one("left_shin"), kShinL);
  EXPECT_EQ(one("tail"), kNone);
  EXPECT_EQ(MeaningOf({"LeftShoulder", "LeftElbow"})[0], kUpperArmL);
  EXPECT_EQ(MeaningOf({"LeftShoulder", "LeftArm"})[0], kCollarL);
}

TEST(MatchJoints, UnknownNamesAreListed) {
  MotionClip clip = MakeClip(1, 1);
  for (std::size_t j = 0; j < clip.joints.size(); ++j)
    clip.joints[j].name = "joint" + std::to_string(j);
  const Rig rig = MakeBody();
  try {
    MatchJoints(clip, rig, {});
    FAIL();
  } catch (const InputError& error) {
    const std::string words = error.what();
    EXPECT_NE(words.find("joint1"), std::string::npos);
    EXPECT_NE(words.find("upperarm01.L"), std::string::npos);
    EXPECT_NE(words.find("--joints"), std::string::npos);
  }
  EXPECT_EQ(MatchJoints(clip, rig, {{"joint3", "wrist.L"}})[rig.Find("wrist.L")], 3);
  EXPECT_THROW(MatchJoints(clip, rig, {{"joint99", "wrist.L"}}), InputError);
  EXPECT_THROW(MatchJoints(clip, rig, {{"joint3", "paw"}}), InputError);
}

TEST(MakeRig, ReadsGraphsAndMatrices) {
  const Mesh box = MakeBox(1, 1, 1);
  std::string weights = "2 8\n";
  for (int i = 0; i < 8; ++i) weights += i % 2 ? "1\n" : "0.5\n";
  for (int i = 0; i < 8; ++i) weights += i % 2 ? "0\n" : "0.5\n";
  const std::string skeleton = "1 0 0 0\n2 0 0 1\n3 0 0 2\n#\n2 3\n1 2\n#\n";
  const Rig rig = MakeRig(box, skeleton, "a.tgf", weights, "a.dmat");
  ASSERT_EQ(rig.bones.size(), 2u);
  EXPECT_EQ(rig.bones[0].name, "1-2");
  EXPECT_EQ(rig.bones[1].parent, 0);
  EXPECT_EQ(rig.weights[1], (std::vector<std::pair<int, double>>{{rig.Find("2-3"), 1.0}}));
  EXPECT_EQ(rig.weights[0].size(), 2u);
  EXPECT_THROW(MakeRig(box, skeleton, "a.tgf", "3 8\n", "a.dmat"), InputError);
  EXPECT_THROW(MakeRig(box, skeleton, "a.tgf", "2 8\n1 1 1\n", "a.dmat"), InputError);
  EXPECT_THROW(MakeRig(box, "1 0 0 0\n#\n1 9\n", "a.tgf", weights, "a.dmat"), InputError);
}

TEST(MakeRig, ReadsMakeHumansFiles) {
  const Mesh box = MakeBox(1, 1, 1);
  const std::string skeleton =
      R"({"bones": {"hand": {"head": "b", "tail": "c", "parent": "arm"},
                    "arm": {"head": "a", "tail": "b", "parent": null}},
          "joints": {"a": [0], "b": [0, 1], "c": [2]}})";
  const Rig rig =
      MakeRig(box, skeleton, "a.mhskel", R"({"weights": {"hand": [[3, 2.0]]}})", "a.mhw");
  EXPECT_EQ(rig.bones[0].name, "arm");
  EXPECT_EQ(rig.bones[1].head, 0.5 * (box.points.row(0) + box.points.row(1)).transpose());
  EXPECT_EQ(rig.weights[3], (std::vector<std::pair<int, double>>{{1, 1.0}}));
  const auto fails = [&](const std::string& s, const std::string& w) {
    EXPECT_THROW(MakeRig(box, s, "a.mhskel", w, "a.mhw"), InputError) << s << w;
  };
  fails(skeleton, R"({"weights": {"paw": [[3, 1]]}})");
  fails(skeleton, R"({"weights": {"hand": [[8, 1]]}})");
  fails(R"({"bones": {"a": {"head": "a", "tail": "a", "parent": "b"}}, "joints": {"a": [0]}})",
        R"({"weights": {}})");
  fails(R"({"bones": {"a": {"head": "x", "tail": "a"}}, "joints": {"a": [0]}})",
        R"({"weights": {}})");
  fails("{", "{");
}

TEST(LargestPart, KeepsItsVerticesInOrder) {
  Rig rig;
  rig.mesh = MakeBox(1, 1, 1);
  rig.mesh.points.conservativeResize(11, 3);
  rig.mesh.points.bottomRows(3).setRandom();
  rig.mesh.faces.conservativeResize(13, 3);
  rig.mesh.faces.row(12) << 8, 9, 10;
  rig.weights.resize(11);
  const Rig part = LargestPart(rig);
  EXPECT_EQ(part.mesh.points, MakeBox(1, 1, 1).points);
  EXPECT_EQ(part.mesh.faces, MakeBox(1, 1, 1).faces);
}

}  // namespace
}  // namespace keypose::motion
