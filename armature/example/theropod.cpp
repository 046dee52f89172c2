#include "armature/example/theropod.h"

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "core/values/angles.h"

namespace keypose::armature {
namespace {

using Eigen::Vector3d;

const Vector3d kX = Vector3d::UnitX(), kY = Vector3d::UnitY(), kZ = Vector3d::UnitZ();

/// Adds nodes; sensors are numbered in the order of the joints.
class Builder {
 public:
  Builder() { made_.metres_per_unit = 0.001; }

  int Add(int parent, NodeKind kind, const std::string& name, const Vector3d& axis) {
    ArmatureNode node;
    node.name = name;
    node.parent = parent;
    node.kind = kind;
    node.axis = axis;
    made_.nodes.push_back(node);
    const int index = static_cast<int>(made_.nodes.size()) - 1;
    if (node.moves()) {
      made_.nodes.back().sensor = static_cast<int>(made_.joints.size());
      made_.joints.push_back(index);
    }
    return index;
  }
  int Joint(int parent, const std::string& name, const Vector3d& axis, double scale) {
    const int index = Add(parent, NodeKind::kJoint, name, axis);
    made_.nodes.back().scale = scale;
    return index;
  }
  /// A hinge that stops where a knee does: it does not bend to the other side.
  int Knee(int parent, const std::string& name, double scale) {
    const int index = Joint(parent, name, kX, scale);
    made_.nodes.back().low = -150 * kDegree;
    made_.nodes.back().high = 0;
    return index;
  }
  /// A carriage on a spindle of 5 mm a turn.
  int Slide(int parent, const std::string& name, const Vector3d& axis) {
    const int index = Add(parent, NodeKind::kSlide, name, axis);
    made_.nodes.back().scale = 200;
    return index;
  }
  int Rod(int parent, const std::string& name, double length_m, const Vector3d& axis) {
    const int index = Add(parent, NodeKind::kRod, name, axis);
    made_.nodes.back().length = length_m;
    return index;
  }
  Armature Take() { return std::move(made_); }

 private:
  Armature made_;
};

constexpr int kTrunkParts = 8, kChestPart = 4, kTailParts = 9;
constexpr double kHipHeight_m = 0.36, kHipWidth_m = 0.05, kShoulderWidth_m = 0.045;
/// Between the two hinges of one place: an inch or less, as the paper says.
constexpr double kBetweenHinges_m = 0.012;
constexpr double kTrunkPart_m = 0.045, kTailPart_m = 0.048, kSkull_m = 0.09;
constexpr double kThigh_m = 0.13, kShin_m = 0.13, kFoot_m = 0.08, kToes_m = 0.05;
constexpr double kUpperArm_m = 0.06, kForearm_m = 0.05, kHand_m = 0.03;

int AddRig(Builder* builder) {
  int at = builder->Rod(-1, "rigPost", kHipHeight_m, kZ);
  at = builder->Slide(at, "rigAcross", kX);
  at = builder->Slide(at, "rigAlong", kY);
  at = builder->Slide(at, "rigLift", kZ);
  at = builder->Joint(at, "rigYaw", kZ, 50);
  at = builder->Joint(at, "rigPitch", kX, 50);
  at = builder->Joint(at, "rigRoll", kY, -50);
  return builder->Add(at, NodeKind::kGroup, "pelvis", kY);
}

/// Hinges in pairs with rods between them, parts `first` to `last`. @return the last rod
int AddRow(Builder* builder, int at, const std::string& name, int first, int last, double part_m,
           const Vector3d& along) {
  for (int i = first; i <= last; ++i) {
    const std::string number = std::to_string(i);
    at = builder->Joint(at, name + "Bend" + number, kX, 25);
    at = builder->Rod(at, name + "Link" + number, kBetweenHinges_m, along);
    at = builder->Joint(at, name + "Side" + number, kZ, -25);
    at = builder->Rod(at, name + "Rod" + number, part_m - kBetweenHinges_m, along);
  }
  return at;
}

void AddHead(Builder* builder, int at) {
  at = builder->Joint(at, "headBend", kX, 25);
  at = builder->Joint(at, "headSide", kZ, 25);
  at = builder->Joint(at, "headSwivel", kY, -10);
  builder->Rod(at, "skull", kSkull_m, kY);
  at = builder->Joint(at, "jaw", kX, 10);
  builder->Rod(at, "jawRod", 0.8 * kSkull_m, kY);
}

void AddLeg(Builder* builder, int pelvis, const std::string& side, double sign) {
  int at = builder->Rod(pelvis, side + "HipBar", kHipWidth_m, sign * kX);
  at = builder->Joint(at, side + "HipSwing", kY, 25 * sign);
  at = builder->Joint(at, side + "HipBend", kX, 25);
  at = builder->Joint(at, side + "HipSwivel", kZ, -10 * sign);
  at = builder->Rod(at, side + "Thigh", kThigh_m, -kZ);
  at = builder->Knee(at, side + "KneeBend", 25);
  at = builder->Rod(at, side + "Calve", kShin_m, -kZ);
  at = builder->Joint(at, side + "AnkleSwivel", kZ, -10);
  at = builder->Joint(at, side + "AnkleBend", kX, 25);
  at = builder->Rod(at, side + "Foot", kFoot_m, -kZ);
  at = builder->Joint(at, side + "FootBend", kX, 25);
  at = builder->Rod(at, side + "Sole", 0.4 * kToes_m, kY);
  at = builder->Joint(at, side + "ToeBend", kX, 10);
  builder->Rod(at, side + "Toes", 0.6 * kToes_m, kY);
}

void AddArm(Builder* builder, int chest, const std::string& side, double sign) {
  int at = builder->Rod(chest, side + "ShoulderBar", kShoulderWidth_m, sign * kX);
  at = builder->Joint(at, side + "ShoulderSwing", kY, 10 * sign);
  at = builder->Joint(at, side + "ShoulderBend", kX, 10);
  at = builder->Joint(at, side + "ShoulderSwivel", kZ, -10 * sign);
  at = builder->Rod(at, side + "UpperArm", kUpperArm_m, -kZ);
  at = builder->Knee(at, side + "ElbowBend", 10);
  at = builder->Rod(at, side + "Forearm", kForearm_m, kY);
  at = builder->Joint(at, side + "WristSwivel", kY, -10);
  at = builder->Joint(at, side + "WristBend", kX, 10);
  at = builder->Rod(at, side + "Hand", 0.6 * kHand_m, kY);
  at = builder->Joint(at, side + "Claws", kX, 10);
  builder->Rod(at, side + "ClawRod", 0.4 * kHand_m, kY);
}

/// How a joint swings in the walk: middle + swing * sin(phase + ...), [rad].
struct Swing {
  double middle = 0, swing = 0, phase = 0;
};

/// Of the joints of the left side without the word "left"; the right side is half a stride later.
const std::map<std::string, Swing>& LimbSwings() {
  static const std::map<std::string, Swing> swings = {
      {"HipSwing", {0.04, 0.03, 0.4}},   {"HipBend", {0.5, 0.45, 0}},
      {"HipSwivel", {0, 0.05, 1.0}},     {"KneeBend", {-1.0, 0.45, 1.9}},
      {"AnkleSwivel", {0, 0.04, 0.6}},   {"AnkleBend", {0.9, 0.4, 2.6}},
      {"FootBend", {-0.3, 0.3, 3.4}},    {"ToeBend", {0.1, 0.25, 4.2}},
      {"ShoulderSwing", {0.1, 0.04, 2}}, {"ShoulderBend", {0.5, 0.2, 3.14}},
      {"ShoulderSwivel", {0, 0.05, 1}},  {"ElbowBend", {-0.6, 0.2, 3.6}},
      {"WristSwivel", {0, 0.1, 0.3}},    {"WristBend", {-0.3, 0.15, 4}},
      {"Claws", {-0.4, 0.2, 4.6}}};
  return swings;
}

const std::map<std::string, Swing>& OtherSwings() {
  static const std::map<std::string, Swing> swings = {
      {"rigAcross", {0, 0.012, 0.2}},  {"rigAlong", {0, 0.008, 0.9}},
      {"rigLift", {-0.03, 0.01, 1.4}}, {"rigYaw", {0, 0.05, 0.5}},
      {"rigPitch", {0.05, 0.03, 1.1}}, {"rigRoll", {0, 0.04, 2.0}},
      {"headBend", {-0.35, 0.08, 2}},  {"headSide", {0, 0.1, 2.5}},
      {"headSwivel", {0, 0.05, 1.2}},  {"jaw", {-0.25, 0.2, 0.8}}};
  return swings;
}

/// Bends of trunk and tail: a wave that runs along them.
Swing WaveSwing(const std::string& name) {
  const double number = name.back() - '0';
  const bool side = name.find("Side") != std::string::npos;
  if (name.starts_with("trunk"))
    return {side ? 0 : (number > 4 ? 0.14 : 0.03), side ? 0.05 : 0.02, 0.5 * number};
  return {side ? 0 : 0.03, side ? 0.09 : 0.03, 3 - 0.6 * number};
}

Swing SwingOf(const std::string& name) {
  for (const std::string& side : {std::string("left"), std::string("right")}) {
    if (!name.starts_with(side)) continue;
    Swing swing = LimbSwings().at(name.substr(side.size()));
    if (side == "right") swing.phase += kPi;
    return swing;
  }
  const auto other = OtherSwings().find(name);
  return other == OtherSwings().end() ? WaveSwing(name) : other->second;
}

/// A computer joint below another one.
int AddClipJoint(MotionClip* clip, const std::string& name, int parent, const Vector3d& offset) {
  ClipJoint joint;
  joint.name = name;
  joint.parent = parent;
  joint.offset = offset;
  if (parent < 0)
    joint.channels = {BvhChannel::kXposition, BvhChannel::kYposition, BvhChannel::kZposition};
  if (!name.empty())
    joint.channels.insert(joint.channels.end(),
                          {BvhChannel::kZrotation, BvhChannel::kYrotation, BvhChannel::kXrotation});
  clip->joints.push_back(joint);
  return static_cast<int>(clip->joints.size()) - 1;
}

/// `count` joints at equal steps below another. @return the last
int AddClipRow(MotionClip* clip, const std::string& name, int parent, int count,
               const Vector3d& step) {
  for (int i = 1; i <= count; ++i)
    parent = AddClipJoint(clip, name + std::to_string(i), parent, step);
  return parent;
}

void AddClipLeg(MotionClip* clip, int hips, const std::string& side, double sign) {
  int at = AddClipJoint(clip, side + "UpLeg", hips, sign * kHipWidth_m * kX);
  at = AddClipJoint(clip, side + "Leg", at, -kThigh_m * kZ);
  at = AddClipJoint(clip, side + "Ankle", at, -kShin_m * kZ);
  at = AddClipJoint(clip, side + "Foot", at, -kFoot_m * kZ);
  at = AddClipJoint(clip, side + "Toe", at, 0.4 * kToes_m * kY);
  AddClipJoint(clip, side + "ToeTip", at, 0.6 * kToes_m * kY);
}

void AddClipArm(MotionClip* clip, int chest, const std::string& side, double sign) {
  int at = AddClipJoint(clip, side + "Arm", chest, sign * kShoulderWidth_m * kX);
  at = AddClipJoint(clip, side + "ForeArm", at, -kUpperArm_m * kZ);
  at = AddClipJoint(clip, side + "Hand", at, kForearm_m * kY);
  at = AddClipJoint(clip, side + "Claw", at, 0.6 * kHand_m * kY);
  AddClipJoint(clip, side + "ClawTip", at, 0.4 * kHand_m * kY);
}

constexpr int kTrunkJoints = 2, kNeckJoints = 3, kTailJoints = 7;
/// The computer's rows are a little longer than the armature's.
constexpr double kLonger = 1.02;

}  // namespace

// A node is followed by all below it, as in a file: so the arms come before the neck.
Armature MakeTheropod() {
  Builder builder;
  const int pelvis = AddRig(&builder);
  const int chest = AddRow(&builder, pelvis, "trunk", 1, kChestPart, kTrunkPart_m, kY);
  for (const double sign : {1.0, -1.0}) AddArm(&builder, chest, sign > 0 ? "left" : "right", sign);
  AddHead(&builder,
          AddRow(&builder, chest, "trunk", kChestPart + 1, kTrunkParts, kTrunkPart_m, kY));
  AddRow(&builder, pelvis, "tail", 1, kTailParts, kTailPart_m, -kY);
  for (const double sign : {1.0, -1.0}) AddLeg(&builder, pelvis, sign > 0 ? "left" : "right", sign);
  return builder.Take();
}

ChainPlan MakeTheropodChains(const Armature& theropod) {
  ChainPlan plan;
  const auto anchor = [&](const std::string& name, const std::string& node,
                          const std::string& computer) {
    plan.anchors.push_back({name, theropod.Find(node), computer, 0});
    return static_cast<int>(plan.anchors.size()) - 1;
  };
  const auto chain = [&](const std::string& name, int from, int to,
                         const std::vector<std::string>& nodes,
                         const std::vector<std::string>& computer, ChainMode mode) {
    Chain made{name,     from, to, {plan.anchors[static_cast<std::size_t>(from)].node},
               computer, mode, 0};
    for (const std::string& node : nodes) made.nodes.push_back(theropod.Find(node));
    const int last = plan.anchors[static_cast<std::size_t>(to)].node;
    if (nodes.empty() && mode == ChainMode::kMatch)
      made.nodes = PathBetween(theropod, made.nodes[0], last);
    else
      made.nodes.push_back(last);
    plan.chains.push_back(made);
  };
  const int hips = anchor("hips", "pelvis", "Hips");
  chain("neck", hips, anchor("head", "skull", "HeadTip"), {}, {}, ChainMode::kMatch);
  chain("tail", hips, anchor("tailTip", "tailRod9", "TailTip"), {}, {}, ChainMode::kMatch);
  for (const std::string side : {"left", "right"}) {
    chain(side + "Leg", anchor(side + "Hip", side + "HipSwing", side + "UpLeg"),
          anchor(side + "Toe", side + "Toes", side + "ToeTip"),
          {side + "KneeBend", side + "AnkleSwivel", side + "FootBend", side + "ToeBend"},
          {side + "Leg", side + "Ankle", side + "Foot", side + "Toe"}, ChainMode::kExact);
    chain(side + "Arm", anchor(side + "Shoulder", side + "ShoulderSwing", side + "Arm"),
          anchor(side + "Claw", side + "ClawRod", side + "ClawTip"),
          {side + "ElbowBend", side + "WristSwivel", side + "Claws"},
          {side + "ForeArm", side + "Hand", side + "Claw"}, ChainMode::kExact);
  }
  return plan;
}

MotionClip MakeTheropodSkeleton() {
  MotionClip clip;
  const double trunk_m = kLonger * kTrunkParts * kTrunkPart_m;
  const double joint_m = trunk_m / (kTrunkJoints + kNeckJoints);
  const int hips = AddClipJoint(&clip, "Hips", -1, kHipHeight_m * kZ);
  const int chest = AddClipRow(&clip, "Spine", hips, kTrunkJoints, joint_m * kY);
  for (const double sign : {1.0, -1.0}) AddClipArm(&clip, chest, sign > 0 ? "left" : "right", sign);
  int at = AddClipRow(&clip, "Neck", chest, kNeckJoints, joint_m * kY);
  AddClipJoint(&clip, "HeadTip", at, kSkull_m * kY);
  at = AddClipRow(&clip, "Tail", hips, kTailJoints,
                  -kLonger * kTailParts * kTailPart_m / (kTailJoints + 1) * kY);
  AddClipJoint(&clip, "TailTip", at, clip.joints.back().offset);
  for (const double sign : {1.0, -1.0}) AddClipLeg(&clip, hips, sign > 0 ? "left" : "right", sign);
  clip.frame_time_s = 1.0 / 24;
  clip.values.setZero(1, clip.channel_count());
  clip.values.block<1, 3>(0, 0) = clip.joints[0].offset.transpose();
  return clip;
}

std::vector<double> TheropodWalk(const Armature& theropod, double time_s) {
  constexpr double kStride_s = 1.2;
  const double phase = 2 * kPi * time_s / kStride_s;
  std::vector<double> values;
  for (const int node : theropod.joints) {
    const Swing swing = SwingOf(theropod.nodes[static_cast<std::size_t>(node)].name);
    values.push_back(swing.middle + swing.swing * std::sin(phase + swing.phase));
  }
  return values;
}

std::vector<double> ExampleMotion(const Armature& armature, double time_s) {
  static const Armature theropod = MakeTheropod();
  const auto name = [](const Armature& of, std::size_t j) {
    return of.nodes[static_cast<std::size_t>(of.joints[j])].name;
  };
  bool same = armature.joints.size() == theropod.joints.size();
  for (std::size_t j = 0; same && j < armature.joints.size(); ++j)
    same = name(armature, j) == name(theropod, j);
  if (same) return TheropodWalk(armature, time_s);
  std::vector<double> values;
  for (const int node : armature.joints) {
    const bool slides = armature.nodes[static_cast<std::size_t>(node)].kind == NodeKind::kSlide;
    const double phase = 2 * kPi * time_s / 2 - 0.3 * static_cast<double>(values.size());
    values.push_back((slides ? 0.01 : 0.3) * std::sin(phase));
  }
  return values;
}

}  // namespace keypose::armature
