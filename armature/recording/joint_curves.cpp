#include "armature/recording/joint_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/angles.h"
#include "core/values/errors.h"

namespace keypose::armature {
namespace {

using nlohmann::json;

const ArmatureNode& NodeOf(const Armature& armature, std::size_t joint) {
  return armature.nodes[static_cast<std::size_t>(armature.joints[joint])];
}

std::string UnitOf(const Armature& armature, const ArmatureNode& node) {
  if (node.kind == NodeKind::kJoint) return "rad";
  return armature.metres_per_unit > 0 ? "m" : "";
}

/// The first of `names` that `others` have not, or "".
std::string FirstBeyond(const std::vector<std::string>& names,
                        const std::vector<std::string>& others) {
  for (const std::string& name : names)
    if (std::find(others.begin(), others.end(), name) == others.end()) return name;
  return "";
}

void ReadJoint(const json& entry, const Armature& armature, std::size_t j, JointCurves* curves) {
  const ArmatureNode& node = NodeOf(armature, j);
  if (entry.at("unit") != UnitOf(armature, node))
    throw InputError(fmt::format("joint '{}' is in '{}', and the armature's is in '{}'", node.name,
                                 entry.at("unit").get<std::string>(), UnitOf(armature, node)));
  const auto values = entry.at("values").get<std::vector<double>>();
  if (j == 0)
    curves->values.resize(static_cast<Eigen::Index>(values.size()),
                          static_cast<Eigen::Index>(armature.joints.size()));
  if (static_cast<Eigen::Index>(values.size()) != curves->values.rows())
    throw InputError(fmt::format("joint '{}' has {} frames, and the joints before it {}", node.name,
                                 values.size(), curves->values.rows()));
  for (std::size_t f = 0; f < values.size(); ++f) {
    if (!std::isfinite(values[f]))
      throw InputError(fmt::format("joint '{}' has no number in frame {}", node.name, f));
    curves->values(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(j)) = values[f];
  }
}

/// Channels of a node, and what they hold in one frame.
void AppendChannels(const ArmatureNode& node, double value, std::vector<double>* row) {
  if (node.kind == NodeKind::kSlide) {
    for (int i = 0; i < 3; ++i) row->push_back(value * node.axis[i]);
    return;
  }
  const double angle = node.kind == NodeKind::kJoint ? value : 0;
  const Eigen::Vector3d zyx =
      EulerZyx(Eigen::AngleAxisd(angle, node.axis).toRotationMatrix()) / kDegree;
  row->insert(row->end(), {zyx[0], zyx[1], zyx[2]});
}

ClipJoint ClipJointOf(const ArmatureNode& node) {
  ClipJoint joint;
  joint.name = node.name;
  joint.parent = node.parent + 1;  // behind the root
  if (node.kind == NodeKind::kRod) joint.offset = node.length * node.axis;
  if (node.kind == NodeKind::kSlide)
    joint.channels = {BvhChannel::kXposition, BvhChannel::kYposition, BvhChannel::kZposition};
  else  // also of rods, which stand still: many programs expect that each joint turns
    joint.channels = {BvhChannel::kZrotation, BvhChannel::kYrotation, BvhChannel::kXrotation};
  return joint;
}

}  // namespace

std::string CurvesJson(const Armature& armature, const JointCurves& curves) {
  json joints = json::object();
  for (std::size_t j = 0; j < armature.joints.size(); ++j) {
    const ArmatureNode& node = NodeOf(armature, j);
    json values = json::array();
    for (int f = 0; f < curves.frame_count(); ++f)
      values.push_back(curves.values(f, static_cast<Eigen::Index>(j)));
    joints[node.name] = {
        {"sensor", node.sensor}, {"unit", UnitOf(armature, node)}, {"values", std::move(values)}};
  }
  const json whole = {
      {"schema", 1},         {"kind", "armature curves"},      {"fps", curves.fps},
      {"step", curves.step}, {"frames", curves.frame_count()}, {"joints", std::move(joints)}};
  return whole.dump() + "\n";
}

std::string MisfitOf(const std::vector<std::string>& joints, const Armature& armature) {
  std::vector<std::string> wanted;
  for (std::size_t j = 0; j < armature.joints.size(); ++j)
    wanted.push_back(NodeOf(armature, j).name);
  if (joints == wanted) return "";
  const std::string lacks = FirstBeyond(wanted, joints), beyond = FirstBeyond(joints, wanted);
  if (!lacks.empty() && !beyond.empty())
    return fmt::format(
        "has no joint '{}', but '{}', which the description has not; if that was renamed, give it "
        "its old name in the description again",
        lacks, beyond);
  if (!lacks.empty())
    return fmt::format("has no joint '{}'; it was recorded with another armature", lacks);
  if (!beyond.empty())
    return fmt::format("has a joint '{}', which the description has not", beyond);
  return "has its joints in another order than the description";
}

JointCurves ParseCurvesJson(const std::string& text, const std::string& file,
                            const Armature& armature) {
  RequireShallowJson(text, file);
  JointCurves curves;
  try {
    const json whole = json::parse(text);
    curves.fps = whole.at("fps").get<double>();
    curves.step = whole.at("step").get<int>();
    if (!(curves.fps > 0 && curves.fps <= 1000) || curves.step < 1 || curves.step > 1000)
      throw InputError("fps and step must be positive, and at most 1000");
    const json& joints = whole.at("joints");
    std::vector<std::string> names;
    for (const auto& [name, joint] : joints.items()) names.push_back(name);
    for (std::size_t j = 0; j < armature.joints.size(); ++j) {
      const std::string& name = NodeOf(armature, j).name;
      if (!joints.contains(name)) throw InputError("it " + MisfitOf(names, armature));
      curves.joints.push_back(name);
      ReadJoint(joints[name], armature, j, &curves);
    }
    for (const std::string& name : names)
      if (std::find(curves.joints.begin(), curves.joints.end(), name) == curves.joints.end())
        curves.left_out.push_back(name);
  } catch (const json::exception& error) {
    throw InputError(fmt::format("{}: these are no curves of `keypose armature record`: {}", file,
                                 JsonFault(error)));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file, error.what()));
  }
  return curves;
}

std::string LeftOutWords(const JointCurves& curves) {
  constexpr std::size_t kNamed = 5;
  const std::size_t count = curves.left_out.size();
  if (count == 0) return "";
  std::string names;
  for (std::size_t i = 0; i < std::min(count, kNamed); ++i)
    names += (i ? ", '" : "'") + curves.left_out[i] + "'";
  if (count > kNamed) names += fmt::format(" and {} more", count - kNamed);
  return fmt::format(
      "the take has {} {}, which the description has not: what {} did is left out; to have it, "
      "give the description as it was when the take was recorded",
      count == 1 ? "a joint" : "joints", names, count == 1 ? "it" : "they");
}

std::string CurvesCsv(const Armature& armature, const JointCurves& curves) {
  std::string text = "frame,time_s";
  for (const int n : armature.joints) {
    const ArmatureNode& node = armature.nodes[static_cast<std::size_t>(n)];
    const std::string unit = node.kind == NodeKind::kJoint ? "deg" : UnitOf(armature, node);
    text += fmt::format(",{}{}", node.name, unit.empty() ? "" : "_" + unit);
  }
  text += "\n";
  for (int f = 0; f < curves.frame_count(); ++f) {
    text += fmt::format("{},{}", f, f * curves.step / curves.fps);
    for (std::size_t j = 0; j < armature.joints.size(); ++j) {
      const bool turns = NodeOf(armature, j).kind == NodeKind::kJoint;
      text += fmt::format(",{}",
                          curves.values(f, static_cast<Eigen::Index>(j)) / (turns ? kDegree : 1));
    }
    text += "\n";
  }
  return text;
}

MotionClip CurvesClip(const Armature& armature, const JointCurves& curves) {
  MotionClip clip;
  clip.frame_time_s = 1 / curves.fps;
  ClipJoint root;
  root.name = "armature";
  while (armature.Find(root.name) >= 0) root.name += "_root";
  root.channels = {BvhChannel::kXposition, BvhChannel::kYposition, BvhChannel::kZposition,
                   BvhChannel::kZrotation, BvhChannel::kYrotation, BvhChannel::kXrotation};
  clip.joints.push_back(root);
  for (const ArmatureNode& node : armature.nodes) clip.joints.push_back(ClipJointOf(node));
  clip.values.resize(curves.frame_count() * curves.step, clip.channel_count());
  for (int f = 0; f < curves.frame_count(); ++f) {
    std::vector<double> row(6, 0.0);
    Eigen::Index joint = 0;
    for (const ArmatureNode& node : armature.nodes)
      AppendChannels(node, node.moves() ? curves.values(f, joint++) : 0, &row);
    for (int s = 0; s < curves.step; ++s)
      clip.values.row(f * curves.step + s) =
          Eigen::Map<const Eigen::RowVectorXd>(row.data(), static_cast<Eigen::Index>(row.size()));
  }
  return clip;
}

}  // namespace keypose::armature
