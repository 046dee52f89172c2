#include "pipeline/graph/references.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/values/errors.h"
#include "pipeline/disk/project_paths.h"

namespace keypose::pipeline {
namespace {

[[noreturn]] void Refuse(const Where& where, const std::string& message) {
  throw UsageError(fmt::format("{}: {}", where.Text(), message));
}

const std::vector<std::string> kWords = {
    "$photos",      "$mesh",    "$masks",    "$background", "$cameras", "$landmarks",
    "$stiffness",   "$regions", "$timeline", "$run",        "$video",   "$unmasked",
    "$calibration", "$actor",   "$scan",     "$texture",    "$marks",   "$film",
    "$plate",       "$mattes",  "$clicks",   "$holdout",    "$set",     "$pins"};

/// What a filmed shot gives.
bool IsOfFilm(const std::string& word) {
  return word == "film" || word == "plate" || word == "mattes" || word == "clicks" ||
         word == "holdout" || word == "set";
}

bool IsPath(const std::string& text) {
  return text.starts_with("./") || text.starts_with("../") || text.starts_with("/") ||
         text.starts_with("~");
}

bool TakesLandmarks(const InputRule& rule) {
  const auto is_word = [](const Setting& reference) { return reference.text == "$landmarks"; };
  return std::any_of(rule.for_others.begin(), rule.for_others.end(), is_word);
}

}  // namespace

std::string PhotographsOf(const PoseRule& pose) {
  return WithHome(pose.photos ? pose.photos->text : "photos/" + pose.name);
}

std::string VideoOf(const PoseRule& shot) {
  return WithHome(shot.video ? shot.video->text : "shots/" + shot.name);
}

bool IsUnmasked(const PipelineFile& file, const Disk& disk, const std::filesystem::path& project,
                const std::string& shot) {
  const PoseRule* rule = file.FindPose(shot);
  return rule && !disk.Stat(project / VideoOf(*rule) / "masks");
}

std::optional<Setting> ProjectPath(const PipelineFile& file, const Disk& disk,
                                   const std::filesystem::path& project, const std::string& word) {
  if (IsOfFilm(word)) {
    if (!file.shot) return std::nullopt;
    const ShotRule& shot = *file.shot;
    return word == "film"     ? shot.film
           : word == "plate"  ? shot.plate
           : word == "mattes" ? shot.mattes
           : word == "clicks" ? shot.clicks
           : word == "set"    ? shot.set
                              : shot.holdout;
  }
  if (word == "scan") return file.scan;
  if (word == "texture") return file.texture;
  if (word == "marks" && file.marks) return file.marks;
  const Setting by_itself{word + ".json", {"pipeline.yaml", 1}};
  if (!disk.Stat(project / by_itself.text)) return std::nullopt;
  return by_itself;
}

Flow References::Source(const Setting& path) const {
  Flow flow;
  flow.kind = Flow::Kind::kSource;
  flow.path =
      OnDisk(disk_, project_, std::filesystem::path(WithHome(path.text)).lexically_normal());
  flow.origin = flow.path.generic_string();
  flow.where = path.where;
  return flow;
}

References::References(const PipelineFile& file, const Graph& graph, std::filesystem::path project,
                       const Disk& disk)
    : file_(file), graph_(graph), project_(std::move(project)), disk_(disk) {
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
    if (it != rule.inputs.end() && TakesLandmarks(it->second) && !step->pose.empty())
      step->warnings = LandmarkWarnings(*step);
    const Where where = it != rule.inputs.end() ? it->second.where : rule.where;
    if (result.flows.empty() && !port.optional)
      Refuse(where, fmt::format("step '{}' has nothing for the input '{}' of stage '{}'", step->id,
                                port.name, step->info->stage));
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
  const PoseRule* pose = file_.FindPose(step->pose);
  if (rule.method == StepMethod::kFit && pose && pose->cameras)
    step->warnings.push_back(
        fmt::format("the cameras {} of pose '{}' are not used: those of few photographs are found "
                    "by the template",
                    pose->cameras->text, pose->name));
  std::sort(step->needs.begin(), step->needs.end());
  step->needs.erase(std::unique(step->needs.begin(), step->needs.end()), step->needs.end());
}

std::vector<Flow> References::FlowsOf(const InputRule& rule, const Step& step) const {
  std::vector<Flow> flows;
  if (rule.either) {
    for (const Setting& reference : rule.for_others)
      if (Exists(reference, step)) return Resolve(reference, step);
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
  const std::string& word = reference.text;
  Flow flow;
  flow.where = reference.where;
  if (word == "$timeline") {
    if (graph_.timeline_json.empty()) return {};
    flow.kind = Flow::Kind::kTimeline;
    flow.origin = "the timeline";
    return {flow};
  }
  if (word == "$run") {
    flow.kind = Flow::Kind::kRun;
    flow.origin = "the results of all other steps";
    return {flow};
  }
  if (word == "$landmarks") return Landmarks(reference, step);
  if (word == "$regions" || word == "$stiffness") {
    flow = Source({word.substr(1) + ".json", reference.where});
    return disk_.Stat(project_ / flow.path) ? std::vector<Flow>{flow} : std::vector<Flow>{};
  }
  const bool of_performance = word == "$scan" || word == "$marks" ||
                              (word == "$texture" && file_.kind == ProjectKind::kPerformance);
  if (of_performance || IsOfFilm(word.substr(1))) {
    const auto path = ProjectPath(file_, disk_, project_, word.substr(1));
    return path ? std::vector<Flow>{Source(*path)} : std::vector<Flow>{};
  }
  const bool of_shot = word == "$video" || word == "$unmasked" || word == "$calibration" ||
                       word == "$actor" || word == "$pins";
  const bool of_pose = word == "$photos" || word == "$mesh" || word == "$texture" ||
                       word == "$masks" || word == "$background" || word == "$cameras";
  if (!of_shot && !of_pose)
    Refuse(reference.where, fmt::format("step '{}': '{}' is not known{}", step.rule, word,
                                        Suggestion(word, kWords)));
  const PoseRule* pose = file_.FindPose(step.pose);
  if (!pose)
    Refuse(reference.where,
           fmt::format("step '{}' is not of one pose, so it has no {}", step.rule, word));
  if (of_shot) return ShotWord(reference, *pose);
  if (word == "$photos") {
    flow = Source({PhotographsOf(*pose), pose->photos ? pose->photos->where : pose->where});
    flow.photographs = true;
    return {flow};
  }
  const auto& setting = word == "$masks"     ? pose->masks
                        : word == "$cameras" ? pose->cameras
                        : word == "$mesh"    ? pose->mesh
                        : word == "$texture" ? pose->texture
                                             : pose->background;
  return setting ? std::vector<Flow>{Source(*setting)} : std::vector<Flow>{};
}

std::vector<Flow> References::ShotWord(const Setting& reference, const PoseRule& shot) const {
  const Where where = shot.video ? shot.video->where : shot.where;
  if (reference.text == "$unmasked" && !IsUnmasked(file_, disk_, project_, shot.name)) return {};
  if (reference.text == "$video" || reference.text == "$unmasked")
    return {Source({VideoOf(shot), where})};
  if (reference.text == "$actor" || reference.text == "$pins") {
    const auto& given = reference.text == "$actor" ? shot.actor : shot.pins;
    return given ? std::vector<Flow>{Source(*given)} : std::vector<Flow>{};
  }
  if (shot.calibration) return {Source(*shot.calibration)};
  // Beside the films, or for all shots in the project's own folder.
  for (const std::filesystem::path folder : {VideoOf(shot), std::string(".")}) {
    const auto stat = disk_.Stat(project_ / folder);
    if (!stat || !stat->folder) continue;
    for (const std::string& name : disk_.Children(project_ / folder))
      if (std::filesystem::path(name).stem() == "calibration")
        return {Source({(folder / name).lexically_normal().string(), where})};
  }
  Refuse(shot.where,
         fmt::format("shot '{0}' has no calibration of its cameras; put a file or folder "
                     "`calibration.*` into {1} or into the project, or name it, as in\n  {0}: "
                     "{{video: {1}, calibration: rig.yml}}",
                     shot.name, VideoOf(shot)));
}

std::vector<Flow> References::Landmarks(const Setting& reference, const Step& step) const {
  if (step.pose.empty())
    Refuse(reference.where,
           fmt::format("step '{}' is not of one pose, so it has no $landmarks", step.rule));
  const std::vector<std::string> poses = PosesOfPair(step);
  for (const std::string& name : poses) {
    const auto& named = file_.FindPose(name)->landmarks;
    if (!named || disk_.Stat(project_ / Source(*named).path)) continue;
    throw InputError(fmt::format(
        "{}: the landmarks {} of pose '{}' do not exist; put them there, or correct the line",
        named->where.Text(), named->text, name));
  }
  std::vector<Flow> flows;
  for (const std::string& name : poses) {
    const std::optional<Setting> file = LandmarkFile(name);
    // A file that the project does not name may be missing: then this pair has no landmarks yet.
    if (!file) return {};
    flows.push_back(Source(*file));
  }
  return flows;
}

std::vector<std::string> References::PosesOfPair(const Step& step) const {
  std::vector<std::string> poses = {graph_.template_pose};
  if (step.pose != graph_.template_pose) poses.push_back(step.pose);
  return poses;
}

/// The file that the project names, else landmarks/POSE.json or MeshLab's landmarks/POSE.pp if one
/// exists.
std::optional<Setting> References::LandmarkFile(const std::string& pose_name) const {
  const PoseRule* pose = file_.FindPose(pose_name);
  if (pose->landmarks) return pose->landmarks;
  for (const char* ending : {".json", ".pp"}) {
    const Setting file{"landmarks/" + pose_name + ending, pose->where};
    if (disk_.Stat(project_ / Source(file).path)) return file;
  }
  return std::nullopt;
}

/// What is said of a file of landmarks that bears no pose's name: a pose that was renamed left it.
std::string References::StrayLandmarks() const {
  std::string strays;
  for (const std::filesystem::path file : disk_.Children(project_ / "landmarks")) {
    const std::string name = file.stem().string(), whole = "landmarks/" + file.string();
    const bool named = std::any_of(file_.poses.begin(), file_.poses.end(), [&](const auto& pose) {
      return pose.name == name || (pose.landmarks && pose.landmarks->text == whole);
    });
    if (!named && (file.extension() == ".json" || file.extension() == ".pp"))
      strays += (strays.empty() ? "" : ", ") + whole;
  }
  if (strays.empty()) return "";
  return fmt::format("; {} bears the name of no pose: if this pose was called so, rename the file",
                     strays);
}

/// Warnings about landmark files that are not used.
std::vector<std::string> References::LandmarkWarnings(const Step& step) const {
  std::vector<std::string> warnings;
  const std::vector<std::string> poses = PosesOfPair(step);
  for (const std::string& name : poses) {
    const std::optional<Setting> file = LandmarkFile(name);
    if (!file) continue;
    const std::string picked_points = "landmarks/" + name + ".pp";
    if (file->text != picked_points && disk_.Stat(project_ / picked_points))
      warnings.push_back(
          fmt::format("{} is not used, because {} is there too; delete the one that is not meant",
                      picked_points, file->text));
    for (const std::string& other : poses) {
      if (LandmarkFile(other)) continue;
      warnings.push_back(
          fmt::format("{} is not used: pose '{}' has no landmarks to pair them with; pick the same "
                      "spots on it, with the "
                      "same names, and save them as landmarks/{}.json or .pp{}",
                      file->text, other, other, StrayLandmarks()));
    }
  }
  return warnings;
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
  if (fan_out == FanOut::kAnimation || fan_out == FanOut::kProject) {
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
