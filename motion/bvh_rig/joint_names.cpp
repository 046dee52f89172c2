#include "motion/bvh_rig/joint_names.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::motion {

namespace {

using Words = std::vector<std::string>;

/// Words of a name in lower case, without what stands before a colon.
Words WordsOf(const std::string& name) {
  Words words;
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
  return words;
}

/// -1 none, 0 left, 1 right
int SideOf(const std::string& word) {
  if (word == "l" || word == "left") return 0;
  return word == "r" || word == "right" ? 1 : -1;
}

/// Without first words that nearly all names have, as in "Bip01 L Thigh" or "Character1_Hips".
std::vector<Words> WithoutPrefix(std::vector<Words> names) {
  constexpr double kNearlyAll = 0.9;
  constexpr int kFewest = 4;
  for (;;) {
    std::map<std::string, int> count;
    int all = 0;
    for (const Words& words : names)
      if (!words.empty()) {
        ++count[words[0]];
        ++all;
      }
    const auto most =
        std::max_element(count.begin(), count.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    if (all < kFewest || most->second < kNearlyAll * all) return names;
    const std::string prefix = most->first;
    for (Words& words : names)
      if (!words.empty() && words[0] == prefix) words.erase(words.begin());
  }
}

/// A name in one word, without the side; and the side.
struct PlainName {
  std::string word;
  int side = -1;
};

struct Meaning {
  BodyJoint joint;  // the left one of limbs
  bool limb;
  std::vector<const char*> words;
};

const std::vector<Meaning>& Meanings() {
  using enum BodyJoint;
  static const std::vector<Meaning> table = {
      {kHips, false, {"hips", "hip", "pelvis", "root"}},
      {kSpine,
       false,
       {"spine", "lowerback", "spine1", "waist", "abdomen", "spine04", "torso", "upperback"}},
      {kChest,
       false,
       {"chest", "spine2", "spine3", "chest2", "upperchest", "spine02", "spine01", "thorax"}},
      {kNeck, false, {"neck", "neck01", "neck1"}},
      {kHead, false, {"head"}},
      {kCollarL, true, {"collar", "clavicle", "collarbone"}},
      {kUpperArmL,
       true,
       {"upperarm", "uparm", "arm", "upperarm01", "upperarm1", "shldr", "shldrbend", "humerus"}},
      {kForearmL,
       true,
       {"forearm", "loarm", "lowerarm", "elbow", "lowerarm01", "forearmbend", "radius"}},
      {kHandL, true, {"hand", "wrist"}},
      {kThighL, true, {"thigh", "upleg", "upperleg", "hip", "upperleg01", "thighbend", "femur"}},
      {kShinL, true, {"shin", "leg", "loleg", "lowerleg", "knee", "lowerleg01", "calf", "tibia"}},
      {kFootL, true, {"foot", "ankle"}},
      {kToesL, true, {"toe", "toes", "toebase"}}};
  return table;
}

BodyJoint OnSide(BodyJoint left, int side) {
  const int count = static_cast<int>(BodyJoint::kToesL) - static_cast<int>(BodyJoint::kCollarL) + 1;
  return static_cast<BodyJoint>(static_cast<int>(left) + (side == 1 ? count : 0));
}

bool Means(const Meaning& meaning, const std::string& word) {
  return std::any_of(meaning.words.begin(), meaning.words.end(),
                     [&](const char* known) { return word == known; });
}

bool IsLimbWord(const std::string& word) {
  return std::any_of(Meanings().begin(), Meanings().end(),
                     [&](const Meaning& meaning) { return meaning.limb && Means(meaning, word); });
}

PlainName PlainOf(const Words& words) {
  PlainName plain;
  for (const std::string& word : words)
    if (SideOf(word) >= 0)
      plain.side = SideOf(word);
    else
      plain.word += word;
  // As in "lhand" and "RHipJoint" of CMU, whose first letter is a word of its own only sometimes.
  if (plain.side >= 0 || plain.word.empty()) return plain;
  const int side = SideOf(plain.word.substr(0, 1));
  const std::string rest = plain.word.substr(1);
  return side >= 0 && (rest == "hipjoint" || IsLimbWord(rest)) ? PlainName{rest, side} : plain;
}

BodyJoint MeaningOfPlain(const PlainName& name, bool shoulder_is_arm) {
  if (name.word == "shoulder" && name.side >= 0)
    return OnSide(shoulder_is_arm ? BodyJoint::kUpperArmL : BodyJoint::kCollarL, name.side);
  for (const Meaning& meaning : Meanings())
    if (meaning.limb == (name.side >= 0) && Means(meaning, name.word))
      return meaning.limb ? OnSide(meaning.joint, name.side) : meaning.joint;
  return BodyJoint::kNone;
}

/// Blender's metarig numbers the trunk from the hips up to the head.
void NameMetarig(std::vector<PlainName>& names) {
  static const std::map<std::string, std::string> meant = {
      {"spine", "hips"},    {"spine001", "spine"}, {"spine002", "spine"}, {"spine003", "chest"},
      {"spine004", "neck"}, {"spine005", ""},      {"spine006", "head"}};
  const auto has = [&](const char* word) {
    return std::any_of(names.begin(), names.end(),
                       [&](const PlainName& name) { return name.side < 0 && name.word == word; });
  };
  if (!has("spine006") || has("hips") || has("head")) return;
  for (PlainName& name : names)
    if (const auto found = meant.find(name.word); found != meant.end()) name.word = found->second;
}

/// Whether of two names of one meaning the later one is meant: the body's hips under a root that
/// stays on the floor, and the joint under a helper of the same name, as "UpLeg_L" under
/// "__UpLeg_L" in clips from Blender.
bool IsMeantRather(const PlainName& later, const PlainName& earlier) {
  return later.word == earlier.word || earlier.word == "root";
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

constexpr int kEnough = 4;  // of the eight main joints

std::vector<BodyJoint> MeaningOfWords(const std::vector<Words>& names) {
  std::vector<PlainName> plain;
  for (const Words& words : names) plain.push_back(PlainOf(words));
  NameMetarig(plain);
  bool arm = false, elbow = false;
  for (const PlainName& name : plain) {
    arm |=
        name.side >= 0 && MeaningOfPlain(name, false) == OnSide(BodyJoint::kUpperArmL, name.side);
    elbow |= name.word == "elbow";
  }
  std::vector<BodyJoint> result(plain.size(), BodyJoint::kNone);
  std::map<BodyJoint, int> taken;
  for (int k = 0; k < SizeOf(plain); ++k) {
    const BodyJoint joint = MeaningOfPlain(plain[k], elbow && !arm);
    if (joint == BodyJoint::kNone) continue;
    const auto [at, fresh] = taken.emplace(joint, k);
    // Spines and chests are chains; of other names of one meaning, only one counts.
    const bool chain = joint == BodyJoint::kSpine || joint == BodyJoint::kChest;
    if (!fresh && !chain) {
      if (!IsMeantRather(plain[k], plain[at->second])) continue;
      result[at->second] = BodyJoint::kNone;
      at->second = k;
    }
    result[k] = joint;
  }
  return result;
}

int MainCount(const std::vector<BodyJoint>& joints) {
  return static_cast<int>(std::count_if(joints.begin(), joints.end(), IsMain));
}

/// By equal names or, where these are too few, by what names mean.
std::vector<int> GuessedMatch(const MotionClip& clip, const std::vector<std::string>& joints,
                              const std::vector<std::string>& bones) {
  std::vector<int> match(bones.size(), -1);
  for (int b = 0; b < SizeOf(bones); ++b) match[b] = clip.Find(bones[b]);
  const std::vector<BodyJoint> of_bones = MeaningOf(bones), of_joints = MeaningOf(joints);
  if (MainMatches(match, of_bones) >= kEnough) return match;
  std::fill(match.begin(), match.end(), -1);
  for (int b = 0; b < SizeOf(bones); ++b) {
    if (of_bones[b] == BodyJoint::kNone) continue;
    // The last joint of a chain carries what the ones before it have turned.
    for (int j = 0; j < SizeOf(joints); ++j)
      if (of_joints[j] == of_bones[b]) match[b] = j;
  }
  return match;
}

std::vector<std::string> NamesOf(const RiggedMesh& rig) {
  std::vector<std::string> names;
  for (const Bone& bone : rig.bones) names.push_back(bone.name);
  return names;
}

}  // namespace

std::vector<BodyJoint> MeaningOf(const std::vector<std::string>& names) {
  std::vector<Words> words;
  for (const std::string& name : names) words.push_back(WordsOf(name));
  std::vector<BodyJoint> as_written = MeaningOfWords(words);
  if (MainCount(as_written) >= kEnough) return as_written;
  std::vector<BodyJoint> bare = MeaningOfWords(WithoutPrefix(words));
  return MainCount(bare) > MainCount(as_written) ? bare : as_written;
}

std::vector<int> MatchJoints(const MotionClip& clip, const RiggedMesh& rig,
                             const std::vector<JointName>& given) {
  std::vector<std::string> joints;
  for (const ClipJoint& joint : clip.joints) joints.push_back(joint.name);
  const std::vector<std::string> bones = NamesOf(rig);
  std::vector<int> match = GuessedMatch(clip, joints, bones);
  if (given.empty() && MainMatches(match, MeaningOf(bones)) < kEnough)
    throw InputError("animate: the clip's joints cannot be told apart; found are only " +
                     std::to_string(MainMatches(match, MeaningOf(bones))) +
                     " of the eight upper and lower arms and legs. The clip has " + ListOf(joints) +
                     "; the rig has " + ListOf(bones) +
                     ". Pass a table with --joints: {\"joints\": {\"CLIP JOINT\": \"RIG BONE\", "
                     "...}}");
  for (const auto& [joint, bone] : given) {
    const int j = clip.Find(joint), b = rig.Find(bone);
    if (j < 0 || joint.empty())
      throw InputError("animate: the clip has no joint '" + joint + "'; its joints are " +
                       ListOf(joints));
    if (b < 0)
      throw InputError("animate: the rig has no bone '" + bone + "'; its bones are " +
                       ListOf(bones));
    std::replace(match.begin(), match.end(), j, -1);
  }
  for (const auto& [joint, bone] : given) match[rig.Find(bone)] = clip.Find(joint);
  return match;
}

std::vector<std::string> BonesWithoutJoint(const RiggedMesh& rig, const std::vector<int>& match) {
  const std::vector<std::string> names = NamesOf(rig);
  const std::vector<BodyJoint> meanings = MeaningOf(names);
  std::vector<std::string> missing;
  for (int b = 0; b < SizeOf(names); ++b)
    if (match[b] < 0 && (IsMain(meanings[b]) || meanings[b] == BodyJoint::kHips))
      missing.push_back(names[b]);
  return missing;
}

}  // namespace keypose::motion
