#include "motion/bvh_rig/joint_names.h"

#include <gtest/gtest.h>

#include <string>

#include "core/values/errors.h"
#include "motion/bvh_rig/rigged_mesh.h"
#include "motion/bvh_rig/testing/rigged_body.h"

namespace keypose::motion::joint_names_test {

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

}  // namespace keypose::motion::joint_names_test
