#include "motion/bvh_rig/joint_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <set>

#include "core/errors.h"
#include "core/size_of.h"

namespace keypose::motion {

namespace {

/// Words of a name in lower case, without the side; and the side: -1 none, 0 left, 1 right.
struct PlainName {
  std::string word;
  int side = -1;
};

PlainName PlainOf(const std::string& name) {
  std::vector<std::string> words;
  const std::size_t colon = name.rfind(':');
  const std::string own = colon == std::string::npos ? name : name.substr(colon + 1);
  bool fresh = true, before_lower = false;
  for (const char c : own) {
    const auto u = static_cast<unsigned char>(c);
    const bool letter = std::isalnum(u);
    if (letter && (fresh || (std::isupper(u) && before_lower))) words.emplace_back();
    if (letter) words.back() += static_cast<char>(std::tolower(u));
    fresh = !letter;
    before_lower = letter && !std::isupper(u);
  }
  PlainName plain;
  for (const std::string& word : words) {
    if (word == "l" || word == "left") {
      plain.side = 0;
    } else if (word == "r" || word == "right") {
      plain.side = 1;
    } else {
      plain.word += word;
    }
  }
  // As in "lhand" and "RHipJoint" of CMU, whose first letter is a word of its own only sometimes.
  for (const auto& [letter, side] : {std::pair('l', 0), std::pair('r', 1)})
    if (plain.side < 0 && plain.word.size() > 4 && plain.word[0] == letter &&
        (plain.word.substr(1) == "hipjoint" || plain.word.substr(1) == "hand"))
      plain.side = side, plain.word = plain.word.substr(1);
  return plain;
}

struct Meaning {
  BodyJoint joint;  // the left one of limbs
  bool limb;
  std::vector<const char*> words;
};

const std::vector<Meaning>& Meanings() {
  using enum BodyJoint;
  static const std::vector<Meaning> table = {
      {kHips, false, {"hips", "pelvis", "root"}},
      {kSpine, false, {"spine", "lowerback", "spine1", "waist", "abdomen", "spine04", "torso"}},
      {kChest, false, {"chest", "spine2", "spine3", "chest2", "upperchest", "spine02", "spine01"}},
      {kNeck, false, {"neck", "neck01", "neck1"}},
      {kHead, false, {"head"}},
      {kCollarL, true, {"collar", "clavicle", "collarbone"}},
      {kUpperArmL, true, {"upperarm", "uparm", "arm", "upperarm01", "upperarm1"}},
      {kForearmL, true, {"forearm", "loarm", "lowerarm", "elbow", "lowerarm01"}},
      {kHandL, true, {"hand", "wrist"}},
      {kThighL, true, {"thigh", "upleg", "upperleg", "hip", "upperleg01"}},
      {kShinL, true, {"shin", "leg", "loleg", "lowerleg", "knee", "lowerleg01", "calf"}},
      {kFootL, true, {"foot", "ankle"}},
      {kToesL, true, {"toe", "toes", "toebase"}}};
  return table;
}

BodyJoint OnSide(BodyJoint left, int side) {
  const int count = static_cast<int>(BodyJoint::kToesL) - static_cast<int>(BodyJoint::kCollarL) + 1;
  return static_cast<BodyJoint>(static_cast<int>(left) + (side == 1 ? count : 0));
}

BodyJoint MeaningOfPlain(const PlainName& name, bool shoulder_is_arm) {
  if (name.word == "shoulder" && name.side >= 0)
    return OnSide(shoulder_is_arm ? BodyJoint::kUpperArmL : BodyJoint::kCollarL, name.side);
  for (const Meaning& meaning : Meanings())
    if (meaning.limb == (name.side >= 0) &&
        std::any_of(meaning.words.begin(), meaning.words.end(),
                    [&](const char* word) { return name.word == word; }))
      return meaning.limb ? OnSide(meaning.joint, name.side) : meaning.joint;
  return BodyJoint::kNone;
}

bool IsMain(BodyJoint joint) {
  using enum BodyJoint;
  static const std::set<BodyJoint> main = {kUpperArmL, kForearmL, kThighL, kShinL,
                                           kUpperArmR, kForearmR, kThighR, kShinR};
  return main.count(joint) > 0;
}

std::string ListOf(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 24;
  std::string list;
  for (std::size_t k = 0; k < std::min(names.size(), kMost); ++k)
    list += (k ? ", " : "") + names[k];
  return list + (names.size() > kMost ? ", ..." : "");
}

/// @return how many main joints are among the matches
int MainMatches(const std::vector<int>& match, const std::vector<BodyJoint>& bones) {
  int count = 0;
  for (int b = 0; b < SizeOf(match); ++b) count += match[b] >= 0 && IsMain(bones[b]);
  return count;
}

}  // namespace

std::vector<BodyJoint> MeaningOf(const std::vector<std::string>& names) {
  std::vector<PlainName> plain;
  bool arm = false, elbow = false;
  for (const std::string& name : names) {
    plain.push_back(PlainOf(name));
    arm |= plain.back().side >= 0 &&
           MeaningOfPlain(plain.back(), false) == OnSide(BodyJoint::kUpperArmL, plain.back().side);
    elbow |= plain.back().word == "elbow";
  }
  std::vector<BodyJoint> result;
  std::set<BodyJoint> taken;
  for (const PlainName& name : plain) {
    const BodyJoint joint = MeaningOfPlain(name, elbow && !arm);
    // The first of several names wins, but spines and chests are chains.
    const bool chain = joint == BodyJoint::kSpine || joint == BodyJoint::kChest;
    const bool fresh = joint != BodyJoint::kNone && (taken.insert(joint).second || chain);
    result.push_back(fresh ? joint : BodyJoint::kNone);
  }
  return result;
}

std::vector<int> MatchJoints(const MotionClip& clip, const Rig& rig,
                             const std::vector<JointName>& given) {
  std::vector<std::string> joints, bones;
  for (const ClipJoint& joint : clip.joints) joints.push_back(joint.name);
  for (const Bone& bone : rig.bones) bones.push_back(bone.name);
  std::vector<int> match(bones.size(), -1);
  for (const auto& [joint, bone] : given) {
    const int j = clip.Find(joint), b = rig.Find(bone);
    if (j < 0 || joint.empty())
      throw InputError("animate: the clip has no joint '" + joint + "'; its joints are " +
                       ListOf(joints));
    if (b < 0)
      throw InputError("animate: the rig has no bone '" + bone + "'; its bones are " +
                       ListOf(bones));
    match[b] = j;
  }
  if (!given.empty()) return match;
  for (int b = 0; b < SizeOf(bones); ++b) match[b] = clip.Find(bones[b]);
  const std::vector<BodyJoint> of_bones = MeaningOf(bones), of_joints = MeaningOf(joints);
  constexpr int kEnough = 4;
  if (MainMatches(match, of_bones) >= kEnough) return match;
  std::fill(match.begin(), match.end(), -1);
  for (int b = 0; b < SizeOf(bones); ++b) {
    if (of_bones[b] == BodyJoint::kNone) continue;
    // The last joint of a chain carries what the ones before it have turned.
    for (int j = 0; j < SizeOf(joints); ++j)
      if (of_joints[j] == of_bones[b]) match[b] = j;
  }
  if (MainMatches(match, of_bones) < kEnough)
    throw InputError("animate: the clip's joints cannot be told apart; found are only " +
                     std::to_string(MainMatches(match, of_bones)) +
                     " of the eight upper and lower arms and legs. The clip has " + ListOf(joints) +
                     "; the rig has " + ListOf(bones) +
                     ". Pass a table with --joints: {\"joints\": {\"CLIP JOINT\": \"RIG BONE\", "
                     "...}}");
  return match;
}

}  // namespace keypose::motion
