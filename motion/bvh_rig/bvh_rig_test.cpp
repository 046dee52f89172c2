#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/numbers/rotations.h"
#include "core/surfaces/shapes.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "motion/bvh_rig/joint_names.h"
#include "motion/bvh_rig/retarget.h"
#include "motion/bvh_rig/rig_text.h"
#include "motion/bvh_rig/rigged_mesh.h"

namespace keypose::motion::bvh_rig_test {

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
RiggedMesh MakeBody() {
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

TEST(Skinned, BoneTurnsItsVerticesAboutItsHead) {
  const RiggedMesh rig = MakeBody();
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

/// The place in the list of the one name that has this meaning; -1: none; -2: several.
int PlaceOf(BodyJoint joint, const std::vector<std::string>& names) {
  const std::vector<BodyJoint> meanings = MeaningOf(names);
  int place = -1;
  for (std::size_t k = 0; k < meanings.size(); ++k)
    if (meanings[k] == joint) place = place == -1 ? static_cast<int>(k) : -2;
  return place;
}

TEST(MeaningOf, HelpersAndRootsGiveWayToTheJointsUnderThem) {
  using enum BodyJoint;
  const std::vector<std::string> blender = {"Root", "__UpArm_L", "UpArm_L", "LoArm_L",
                                            "Hips", "__UpLeg_L", "UpLeg_L", "LoLeg_L"};
  EXPECT_EQ(PlaceOf(kHips, blender), 4);
  EXPECT_EQ(PlaceOf(kUpperArmL, blender), 2);
  EXPECT_EQ(PlaceOf(kThighL, blender), 6);
  EXPECT_EQ(PlaceOf(kHips, {"root", "pelvis", "thigh_l"}), 1);
  EXPECT_EQ(PlaceOf(kHips, {"Hips", "Pelvis"}), 0);
  EXPECT_EQ(PlaceOf(kFootL, {"L_Ankle", "L_Foot"}), 0);
}

TEST(MeaningOf, PrefixesThatAllNamesHaveDoNotMatter) {
  using enum BodyJoint;
  for (const std::string prefix :
       {"mixamorig_", "mixamorig", "Character1_", "CC_Base_", "Bip01 "}) {
    std::vector<std::string> names = {"Hips"};
    for (const char* side : {"Left", "Right"})
      for (const char* limb : {"Arm", "ForeArm", "UpLeg", "Leg"})
        names.push_back(std::string(side) + limb);
    for (std::string& name : names) name = prefix + name;
    names.insert(names.begin(), "RL_BoneRoot");
    EXPECT_EQ(PlaceOf(kHips, names), 1) << prefix;
    EXPECT_EQ(PlaceOf(kForearmL, names), 3) << prefix;
    EXPECT_EQ(PlaceOf(kThighR, names), 8) << prefix;
  }
}

TEST(MeaningOf, KnowsPosersAndTheMetarigsNames) {
  using enum BodyJoint;
  const std::vector<std::string> poser = {"hip",   "abdomen", "chest",  "neck",
                                          "head",  "lCollar", "lShldr", "lForeArm",
                                          "lHand", "lThigh",  "lShin",  "lFoot"};
  const std::vector<BodyJoint> meant = {kHips,      kSpine,    kChest, kNeck,   kHead,  kCollarL,
                                        kUpperArmL, kForearmL, kHandL, kThighL, kShinL, kFootL};
  EXPECT_EQ(MeaningOf(poser), meant);
  const std::vector<std::string> metarig = {"spine",     "spine.001", "spine.002", "spine.003",
                                            "spine.004", "spine.005", "spine.006", "thigh.L"};
  const std::vector<BodyJoint> trunk = {kHips, kSpine, kSpine, kChest,
                                        kNeck, kNone,  kHead,  kThighL};
  EXPECT_EQ(MeaningOf(metarig), trunk);
}

TEST(MatchJoints, ATableOfSomeNamesLeavesTheOthersToBeFound) {
  MotionClip clip = MakeClip(1, 1);
  const int odd = clip.Find("LeftArm");
  clip.joints[odd].name = "Oberarm links";
  const RiggedMesh rig = MakeBody();
  std::vector<int> match = MatchJoints(clip, rig, {});
  EXPECT_EQ(BonesWithoutJoint(rig, match), std::vector<std::string>{"upperarm01.L"});
  match = MatchJoints(clip, rig, {{"Oberarm links", "upperarm01.L"}});
  EXPECT_TRUE(BonesWithoutJoint(rig, match).empty());
  EXPECT_EQ(match[rig.Find("upperarm01.L")], odd);
  EXPECT_EQ(match[rig.Find("lowerleg01.R")], clip.Find("RightLeg"));
  // A joint that the table gives to another bone moves only that one.
  match = MatchJoints(clip, rig, {{"RightLeg", "foot.R"}});
  EXPECT_EQ(match[rig.Find("foot.R")], clip.Find("RightLeg"));
  EXPECT_EQ(match[rig.Find("lowerleg01.R")], -1);
}

TEST(MatchJoints, UnknownNamesAreListed) {
  MotionClip clip = MakeClip(1, 1);
  for (std::size_t j = 0; j < clip.joints.size(); ++j)
    clip.joints[j].name = "joint" + std::to_string(j);
  const RiggedMesh rig = MakeBody();
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
  const RiggedMesh rig = MakeRig(box, skeleton, "a.tgf", weights, "a.dmat");
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
  const RiggedMesh rig =
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
  RiggedMesh rig;
  rig.mesh = MakeBox(1, 1, 1);
  rig.mesh.points.conservativeResize(11, 3);
  rig.mesh.points.bottomRows(3).setRandom();
  rig.mesh.faces.conservativeResize(13, 3);
  rig.mesh.faces.row(12) << 8, 9, 10;
  rig.weights.resize(11);
  const RiggedMesh part = LargestPart(rig);
  EXPECT_EQ(part.mesh.points, MakeBox(1, 1, 1).points);
  EXPECT_EQ(part.mesh.faces, MakeBox(1, 1, 1).faces);
}

}  // namespace keypose::motion::bvh_rig_test
