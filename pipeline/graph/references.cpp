#include "pipeline/graph/references.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/values/errors.h"
#include "pipeline/graph/pair_sources.h"

namespace keypose::pipeline {
namespace {

[[noreturn]] void Refuse(const Where& where, const std::string& message) {
  throw UsageError(fmt::format("{}: {}", where.Text(), message));
}

bool IsPath(const std::string& text) {
  return text.starts_with("./") || text.starts_with("../") || text.starts_with("/") ||
         text.starts_with("~");
}

}  // namespace

Flow References::Source(const Setting& path) const {
  Flow flow;
  flow.kind = Flow::Kind::kSource;
  flow.path = sources_.Located(path);
  flow.origin = flow.path.generic_string();
  flow.where = path.where;
  return flow;
}

References::References(const PipelineFile& file, const Graph& graph, std::filesystem::path project,
                       const Disk& disk)
    : file_(file), graph_(graph), sources_(file, disk, std::move(project), graph.template_pose) {
  for (std::size_t i = 0; i < graph.steps.size(); ++i)
    index_[graph.steps[i].id] = static_cast<int>(i);
}

void References::Connect(const StepRule& rule, int index, Step* step) const {
  std::vector<std::string> known;
  for (const PortInfo& port : step->info->inputs) known.push_back(port.name);
  for (const auto& [port, input] : rule.inputs) {
    if (!step->info->FindInput(port)) {
      Refuse(input.where, fmt::format("step '{}': stage '{}' has no input '{}'{}", rule.name,
                                      step->info->stage, port, Suggestion(port, known)));
    }
  }
  for (const PortInfo& port : step->info->inputs) {
    PortFlows result{port.name, port.Kind(), {}};
    const auto it = rule.inputs.find(port.name);
    if (it != rule.inputs.end()) result.flows = FlowsOf(it->second, *step);
    const Where where = it != rule.inputs.end() ? it->second.where : rule.where;
    if (result.flows.empty() && !port.optional)
      Refuse(where, fmt::format("step '{}' has nothing for the input '{}' of stage '{}'{}",
                                step->id, port.name, step->info->stage,
                                it != rule.inputs.end() ? WhyNone(it->second) : ""));
    if (result.flows.size() > 1 && !port.repeatable)
      Refuse(where, fmt::format("step '{}': the input '{}' takes one thing, not {}", step->id,
                                port.name, result.flows.size()));
    if (result.flows.empty()) continue;
    for (const Flow& flow : result.flows) {
      CheckKind(flow, result, *step);
      if (flow.step >= 0) step->needs.push_back(flow.step);
      if (flow.kind != Flow::Kind::kRun) continue;
      for (int i = 0; i < std::ssize(graph_.steps); ++i) {
        if (i != index) step->needs.push_back(i);
      }
    }
    step->inputs.push_back(std::move(result));
  }
  AddWarnings(rule, step);
  std::sort(step->needs.begin(), step->needs.end());
  step->needs.erase(std::unique(step->needs.begin(), step->needs.end()), step->needs.end());
}

/// Of sources that the step does not use.
void References::AddWarnings(const StepRule& rule, Step* step) const {
  const PoseRule* pose = file_.FindPose(step->pose);
  if (!pose) return;
  for (const PortInfo& port : step->info->inputs) {
    const auto input = rule.inputs.find(port.name);
    if (input == rule.inputs.end()) continue;
    for (const Setting& reference : input->second.for_others) {
      const SourceRule* pair =
          reference.text.starts_with("$") ? sources_.Find(reference.text.substr(1)) : nullptr;
      if (!pair || pair->of != SourceOf::kPair) continue;
      for (std::string& warning :
           PairWarnings(sources_, *pair, sources_.PosesOf(*pair, pose), file_.poses))
        step->warnings.push_back(std::move(warning));
    }
  }
  if (rule.method != StepMethod::kFit) return;
  for (const SourceRule& source : file_.sources) {
    const Setting* given = source.no_fit.empty() ? nullptr : pose->Given(source.word);
    if (given)
      step->warnings.push_back(fmt::format("the {} {} of pose '{}' are not used: {}", source.word,
                                           given->text, pose->name, source.no_fit));
  }
}

std::vector<Flow> References::FlowsOf(const InputRule& rule, const Step& step) const {
  std::vector<Flow> flows;
  if (rule.either) {
    Step of = step;
    if (of.pose.empty()) of.pose = graph_.template_pose;
    for (const Setting& reference : rule.for_others)
      if (Exists(reference, of)) return Resolve(reference, of);
    return flows;
  }
  const auto add = [&](const Step& of) {
    for (const Setting& reference : ReferencesFor(rule, of.pose)) {
      for (Flow& flow : Resolve(reference, of)) flows.push_back(std::move(flow));
    }
  };
  if (!rule.split || !step.pose.empty()) {
    add(step);
    return flows;
  }
  for (const std::string& key : graph_.keys) {
    Step of = step;
    of.pose = key;
    add(of);
  }
  return flows;
}

/// Which steps of an `either` are switched off.
std::string References::WhyNone(const InputRule& rule) const {
  std::string why;
  if (!rule.either) return why;
  for (const Setting& reference : rule.for_others) {
    const StepRule* step =
        file_.FindStep(reference.text.substr(0, reference.text.find_first_of(".@")));
    if (step && !step->enabled)
      why += fmt::format("; '{}' is switched off at {}", step->name, step->where.Text());
  }
  return why;
}

/// Whether the step that it names exists for this pose; of words, whether they give anything.
bool References::Exists(const Setting& reference, const Step& step) const {
  if (IsPath(reference.text)) return true;
  if (reference.text.starts_with("$")) return !ResolveWord(reference, step).empty();
  const std::string name = reference.text.substr(0, reference.text.find_first_of(".@"));
  return !file_.FindStep(name) || index_.contains(name) || index_.contains(name + "/" + step.pose);
}

const std::vector<Setting>& References::ReferencesFor(const InputRule& rule,
                                                      const std::string& pose_name) const {
  if (pose_name == graph_.template_pose) return rule.for_template;
  const PoseRule* pose = file_.FindPose(pose_name);
  const bool fitted = pose && pose->FoundBy() == Method::kFit;
  return fitted && rule.for_fit ? *rule.for_fit : rule.for_others;
}

void References::CheckKind(const Flow& flow, const PortFlows& port, const Step& step) const {
  const bool wants_folder = port.kind == PortKind::kFolder;
  bool folder = wants_folder;
  if (flow.kind == Flow::Kind::kOutput)
    folder = graph_.steps[flow.step].info->FindOutput(flow.port)->kind == "folder";
  if (flow.kind == Flow::Kind::kTimeline) folder = false;
  if (port.kind == PortKind::kEither || folder == wants_folder) return;
  Refuse(flow.where,
         fmt::format("step '{}': {} is a {}, but the input '{}' takes a {}", step.id, flow.origin,
                     folder ? "folder" : "file", port.port, wants_folder ? "folder" : "file"));
}

std::vector<Flow> References::Resolve(const Setting& reference, const Step& step) const {
  if (reference.text.starts_with("$")) return ResolveWord(reference, step);
  if (IsPath(reference.text)) return {Source(reference)};
  return ResolveOutput(reference, step);
}

std::vector<Flow> References::ResolveWord(const Setting& reference, const Step& step) const {
  const std::string word = reference.text.substr(1);
  Flow flow;
  flow.where = reference.where;
  if (word == kTimelineWord) {
    if (graph_.timeline_json.empty()) return {};
    flow.kind = Flow::Kind::kTimeline;
    flow.origin = "the timeline";
    return {flow};
  }
  if (word == kRunWord) {
    flow.kind = Flow::Kind::kRun;
    flow.origin = "the results of all other steps";
    return {flow};
  }
  if (!sources_.Knows(word)) {
    std::vector<std::string> known = sources_.Words();
    for (const char* own : {kTimelineWord, kRunWord}) known.push_back(std::string("$") + own);
    Refuse(reference.where, fmt::format("step '{}': '{}' is not known{}", step.rule, reference.text,
                                        Suggestion(reference.text, known)));
  }
  if (word != kUnmaskedWord) return FlowsOfSource(*sources_.Find(word), reference, step);
  if (!sources_.IsUnmasked(*PoseOf(reference, step))) return {};
  return FlowsOfSource(*sources_.Find(kVideoWord), reference, step);
}

/// @throws UsageError  the step is not of one
const PoseRule* References::PoseOf(const Setting& reference, const Step& step) const {
  const PoseRule* pose = file_.FindPose(step.pose);
  if (!pose)
    Refuse(reference.where,
           fmt::format("step '{}' is not of one pose, so it has no {}", step.rule, reference.text));
  return pose;
}

std::vector<Flow> References::FlowsOfSource(const SourceRule& rule, const Setting& reference,
                                            const Step& step) const {
  const PoseRule* pose = sources_.IsOfPose(rule.word) ? PoseOf(reference, step) : nullptr;
  if (rule.of == SourceOf::kPair) RequireNamedFiles(sources_, rule, sources_.PosesOf(rule, pose));
  std::vector<Flow> flows;
  for (const Setting& path : sources_.PathsOf(rule, pose)) {
    flows.push_back(Source(path));
    flows.back().photographs = rule.word == kPhotosWord;
  }
  if (flows.empty() && !rule.required.empty())
    Refuse(pose ? pose->where : reference.where,
           sources_.Filled(rule.required, rule, pose).value_or(rule.required));
  return flows;
}

/// Those of the poses that have an instance of the step.
std::vector<std::string> References::WithStep(const std::string& step,
                                              std::vector<std::string> poses) const {
  std::erase_if(poses,
                [&](const std::string& pose) { return !index_.contains(step + "/" + pose); });
  return poses;
}

std::vector<std::string> References::SelectedPoses(const Setting& reference,
                                                   const std::string& selector,
                                                   const StepRule& rule, const Step& step) const {
  const FanOut fan_out = *rule.fan_out;
  // The template is the first; there may be no pose at all.
  std::vector<std::string> others = graph_.poses;
  if (!others.empty()) others.erase(others.begin());
  if (fan_out == FanOut::kCharacter || fan_out == FanOut::kAnimation ||
      fan_out == FanOut::kProject) {
    if (!selector.empty())
      Refuse(reference.where, fmt::format("'{}': this step is not of a pose, leave '@{}' out",
                                          reference.text, selector));
    return {""};
  }
  if (selector == "template") return {graph_.template_pose};
  if (selector == "others") return WithStep(rule.name, others);
  if (selector == "all") return WithStep(rule.name, graph_.poses);
  if (!selector.empty() && selector != "pose") {
    Refuse(reference.where,
           fmt::format("'{}': '@{}' is not known{}", reference.text, selector,
                       Suggestion(selector, {"pose", "template", "others", "all"})));
  }
  if (fan_out == FanOut::kTemplate) return {graph_.template_pose};
  if (step.pose.empty())
    Refuse(reference.where,
           fmt::format("step '{}' is not of one pose: add @template, @others or @all to '{}'",
                       step.rule, reference.text));
  return {step.pose};
}

/// What to do about a step that a pose does not have; empty when nothing is known.
std::string References::WhyNoStep(const StepRule& rule, const std::string& pose_name) const {
  const PoseRule* pose = file_.FindPose(pose_name);
  if (!pose || rule.method.value_or(StepMethod::kAny) == StepMethod::kAny) return "";
  if (pose->FoundBy() == Method::kFit)
    return fmt::format(
        ", because pose '{}' comes from few photographs (`method: fit`); give the input a "
        "reference for such poses, as in {{template: ..., others: ..., fit: fit.fitted}}, or the "
        "step `method: scan`",
        pose_name);
  return fmt::format(", because pose '{}' is scanned; give the step `method: fit`", pose_name);
}

std::vector<Flow> References::ResolveOutput(const Setting& reference, const Step& step) const {
  const auto dot = reference.text.find('.');
  const auto at = reference.text.find('@');
  const std::string name = reference.text.substr(0, std::min(dot, at));
  const std::string port =
      dot == std::string::npos
          ? ""
          : reference.text.substr(dot + 1, at == std::string::npos ? at : at - dot - 1);
  const std::string selector = at == std::string::npos ? "" : reference.text.substr(at + 1);
  const StepRule* rule = file_.FindStep(name);
  std::vector<std::string> known;
  for (const StepRule& other : file_.steps) known.push_back(other.name);
  if (!rule)
    Refuse(reference.where,
           fmt::format("step '{}': there is no step '{}'{} A path of the project starts with ./",
                       step.rule, name, Suggestion(name, known)));
  if (!rule->enabled)
    Refuse(reference.where, fmt::format("step '{}' takes '{}', but that step is switched off at {}",
                                        step.rule, reference.text, rule->where.Text()));
  std::vector<Flow> flows;
  for (const std::string& pose : SelectedPoses(reference, selector, *rule, step)) {
    const std::string id = pose.empty() ? name : name + "/" + pose;
    const auto it = index_.find(id);
    if (it == index_.end())
      Refuse(reference.where, fmt::format("step '{}' takes '{}', but there is no step {}{}",
                                          step.id, reference.text, id, WhyNoStep(*rule, pose)));
    const StageInfo& info = *graph_.steps[it->second].info;
    if (!info.FindOutput(port)) {
      std::vector<std::string> outputs;
      for (const PortInfo& output : info.outputs) outputs.push_back(output.name);
      Refuse(reference.where, fmt::format("step '{}': stage '{}' has no output '{}'{}", step.rule,
                                          info.stage, port, Suggestion(port, outputs)));
    }
    Flow flow;
    flow.kind = Flow::Kind::kOutput;
    flow.step = it->second;
    flow.port = port;
    flow.origin = id + "." + port;
    flow.where = reference.where;
    flows.push_back(std::move(flow));
  }
  return flows;
}

}  // namespace keypose::pipeline
