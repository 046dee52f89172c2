// `keypose armature check`: reads a description and its chains, and says what they hold.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "armature/armature_commands.h"
#include "armature/description/chain_file.h"
#include "armature/description/description_file.h"
#include "armature/recording/joint_curves.h"
#include "core/io/meshes/bvh_io.h"
#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/values/angles.h"

namespace keypose::armature {
namespace {

using nlohmann::json;

/// Sensors on one card of the controller, as in the paper.
constexpr int kSensorsOnACard = 16;

struct CheckOptions {
  void Describe(OptionVisitor&) {}
};

StageSpec Spec() {
  StageSpec spec;
  spec.name = "armature check";
  spec.version = "1";
  spec.summary =
      "Reads an armature's description and its chains, and says what is wrong or what "
      "they hold.";
  spec.inputs = {
      {"description", "file", "the armature's description file", "", false, false},
      {"chains", "file", "the file of anchors and chains", "", true, false},
      {"skeleton", "file", "the computer skeleton (.bvh) that the chains name", "", true, false},
      {"curves", "file", "a recorded take (curves.json) that shall fit the description", "", true,
       false}};
  spec.outputs = {{"written", "file", "the description as it was read; the same bytes",
                   "description.txt", true, false, true}};
  return spec;
}

json JointReport(const Armature& armature, const ArmatureNode& node) {
  const double counts = std::abs(node.scale) * armature.counts_per_revolution;
  const bool slides = node.kind == NodeKind::kSlide;
  return {{"name", node.name},
          {"line", node.line},
          {"sensor", node.sensor},
          {"card", node.sensor / kSensorsOnACard},
          {"input", node.sensor % kSensorsOnACard},
          {slides ? "step" : "step_deg", slides ? 1 / counts : 360 / counts}};
}

void DescribeJoints(StageContext& stage, const Armature& armature) {
  json joints = json::array();
  for (const int n : armature.joints) {
    const ArmatureNode& node = armature.nodes[static_cast<std::size_t>(n)];
    joints.push_back(JointReport(armature, node));
    const json& row = joints.back();
    const std::string step = row.contains("step")
                                 ? fmt::format("{:.4g} a count", row["step"].get<double>())
                                 : fmt::format("{:.4g} deg a count", row["step_deg"].get<double>());
    stage.Note(fmt::format("  sensor {:3} (card {}, input {:2})  {:20} {}", node.sensor,
                           node.sensor / kSensorsOnACard, node.sensor % kSensorsOnACard, node.name,
                           step));
  }
  stage.ReportJson("joints", joints.dump());
}

/// Sensor indices below the largest that no joint has: inputs that stay empty, or a slip.
void WarnOfGaps(StageContext& stage, const Armature& armature) {
  std::string gaps;
  for (int sensor = 0; sensor < armature.sensor_count(); ++sensor)
    if (armature.JointOfSensor(sensor) < 0)
      gaps += (gaps.empty() ? "" : ", ") + std::to_string(sensor);
  if (!gaps.empty())
    stage.Warn("no joint has sensor " + gaps + "; is an encoder missing in the description?");
}

void CheckSkeleton(const ChainPlan& plan, const MotionClip& skeleton, const std::string& file) {
  std::vector<std::string> names;
  for (const ClipJoint& joint : skeleton.joints)
    if (!joint.name.empty()) names.push_back(joint.name);
  const auto require = [&](const std::string& name, int line) {
    if (skeleton.Find(name) < 0)
      throw InputError(fmt::format("{}:{}: the computer skeleton has no joint '{}'{}", file, line,
                                   name, DidYouMean(name, names)));
  };
  for (const Anchor& anchor : plan.anchors) require(anchor.computer, anchor.line);
  for (const Chain& chain : plan.chains)
    for (const std::string& name : chain.computer) require(name, chain.line);
}

void DescribeChains(StageContext& stage, const Armature& armature) {
  const auto path = stage.Input("chains");
  const std::string file = PrintableName(path);
  const ChainPlan plan = ParseChains(ReadFile(path), file, armature);
  if (stage.Has("skeleton")) CheckSkeleton(plan, ReadBvh(stage.Input("skeleton")), file);
  for (const Chain& chain : plan.chains) {
    const Anchor& from = plan.anchors[static_cast<std::size_t>(chain.from)];
    const Anchor& to = plan.anchors[static_cast<std::size_t>(chain.to)];
    stage.Note(fmt::format("  chain {:12} {} to {}: {} places of the armature, {}", chain.name,
                           from.name, to.name, chain.nodes.size(),
                           chain.mode == ChainMode::kExact ? "joint on joint" : "matched"));
  }
  stage.Note(fmt::format("{} anchors, {} chains", plan.anchors.size(), plan.chains.size()));
  stage.Report("anchors", static_cast<int>(plan.anchors.size()));
  stage.Report("chains", static_cast<int>(plan.chains.size()));
}

void DescribeTake(StageContext& stage, const Armature& armature) {
  const auto path = stage.Input("curves");
  const JointCurves curves = ParseCurvesJson(ReadFile(path), PrintableName(path), armature);
  stage.Note(fmt::format("the take fits: {} recorded frames, {} film frames each, {:g} a second",
                         curves.frame_count(), curves.step, curves.fps));
  stage.Report("recorded_frames", curves.frame_count());
  if (const std::string words = LeftOutWords(curves); !words.empty()) stage.Warn(words);
}

void Run(StageContext& stage, const CheckOptions&) {
  const auto path = stage.Input("description");
  const DescriptionFile file = DescriptionFile::Parse(ReadFile(path), PrintableName(path));
  const Armature& armature = file.armature();
  const int cards = (armature.sensor_count() + kSensorsOnACard - 1) / kSensorsOnACard;
  DescribeJoints(stage, armature);
  stage.Note(fmt::format("{} nodes, {} sensors on {} cards of {}", armature.nodes.size(),
                         armature.joints.size(), cards, kSensorsOnACard));
  stage.Report("nodes", static_cast<int>(armature.nodes.size()));
  stage.Report("sensors", static_cast<int>(armature.joints.size()));
  stage.Report("cards", cards);
  WarnOfGaps(stage, armature);
  if (stage.Has("chains")) DescribeChains(stage, armature);
  if (stage.Has("curves")) DescribeTake(stage, armature);
  if (const auto written = stage.Output("written"); !written.empty())
    WriteFile(written, file.Text());
}

}  // namespace

int CheckCommand(int argc, char** argv) { return RunStage<CheckOptions>(argc, argv, Spec(), Run); }

}  // namespace keypose::armature
