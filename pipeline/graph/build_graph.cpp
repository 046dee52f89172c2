#include "pipeline/graph/build_graph.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <set>

#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/graph/default_timeline.h"
#include "pipeline/graph/references.h"
#include "pipeline/graph/shown_frames.h"
#include "pipeline/graph/wanted_steps.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const Where& where, const std::string& message) {
  throw UsageError(fmt::format("{}: {}", where.Text(), message));
}

std::vector<std::string> StepNames(const PipelineFile& file) {
  std::vector<std::string> names;
  for (const StepRule& rule : file.steps) names.push_back(rule.name);
  return names;
}

std::vector<std::string> PoseNames(const PipelineFile& file) {
  std::vector<std::string> names;
  for (const PoseRule& pose : file.poses) names.push_back(pose.name);
  return names;
}

void CheckPose(const PipelineFile& file, const Setting& pose, const std::string& what) {
  if (!file.FindPose(pose.text))
    Fail(pose.where, fmt::format("{} '{}' is not among the poses{}", what, pose.text,
                                 Suggestion(pose.text, PoseNames(file))));
}

/// Template first, then in the order of the timeline, then in the order of the file.
std::vector<std::string> PoseOrder(const PipelineFile& file, const std::string& template_pose) {
  std::vector<std::string> order;
  std::set<std::string> seen;
  const auto add = [&](const std::string& pose) {
    if (seen.insert(pose).second) order.push_back(pose);
  };
  if (!template_pose.empty()) add(template_pose);
  for (const TimelineKey& key : file.timeline) {
    CheckPose(file, key.pose, "timeline pose");
    add(key.pose.text);
  }
  for (const PoseRule& pose : file.poses) add(pose.name);
  return order;
}

void CheckOptionSteps(const PipelineFile& file, const StepOptionSettings& options) {
  for (const auto& [step, settings] : options) {
    if (!file.FindStep(step))
      Fail(settings.where, fmt::format("options name the step '{}', which does not exist{}", step,
                                       Suggestion(step, StepNames(file))));
  }
}

fs::path ProgramOf(const StepRule& rule, const Places& places, const Disk& disk) {
  if (rule.program) {
    const fs::path program = (places.project / WithHome(rule.program->text)).lexically_normal();
    const auto stat = disk.Stat(program);
    if (!stat || stat->folder)
      Fail(rule.program->where,
           fmt::format("step '{}': there is no program {}", rule.name, program.string()));
    return program;
  }
  if (!rule.stage)
    Fail(rule.where, fmt::format("step '{}' names neither a `stage:` nor a `program:`", rule.name));
  const fs::path program = places.stage_folder / ("keypose-" + rule.stage->text);
  if (disk.Stat(program)) return program;
  std::vector<std::string> known;
  for (const std::string& name : disk.Children(places.stage_folder)) {
    if (name.starts_with("keypose-")) known.push_back(name.substr(8));
  }
  Fail(rule.stage->where,
       fmt::format("step '{}': there is no stage '{}' ({} is missing){}", rule.name,
                   rule.stage->text, program.string(), Suggestion(rule.stage->text, known)));
}

class GraphBuilder {
 public:
  GraphBuilder(const PipelineFile& file, const std::vector<Override>& overrides,
               const Places& places, const Disk& disk, StageCatalog& catalog)
      : file_(file), overrides_(overrides), places_(places), disk_(disk), catalog_(catalog) {}

  Graph Build() {
    CheckHead();
    LoadStages();
    MakeInstances();
    References references(file_, graph_, places_.project, disk_);
    for (std::size_t i = 0; i < graph_.steps.size(); ++i)
      references.Connect(*rule_of_[i], static_cast<int>(i), &graph_.steps[i]);
    for (std::size_t i = 0; i < graph_.steps.size(); ++i) {
      SetOptions(*rule_of_[i], &graph_.steps[i]);
      SetResults(*rule_of_[i], &graph_.steps[i]);
      SetShown(*rule_of_[i], &graph_.steps[i]);
    }
    CheckGivenOptions();
    SortByNeeds();
    CheckResults();
    CheckOverrides();
    return std::move(graph_);
  }

 private:
  void CheckHead() {
    CheckSources(file_);
    const bool performance = file_.kind == ProjectKind::kPerformance;
    if (file_.poses.empty() && performance)
      throw UsageError(
          "pipeline.yaml names no shot; add one, as in\n  shots:\n    walk: shots/walk");
    if (file_.poses.empty() && !HasStepsOnFiles()) {
      throw UsageError(
          "pipeline.yaml names no pose; add one, as in\n  poses:\n    rest: photos/rest");
    }
    if (file_.template_pose) CheckPose(file_, *file_.template_pose, "the template");
    graph_.kind = file_.kind;
    if (file_.template_pose)
      graph_.template_pose = file_.template_pose->text;
    else if (!file_.poses.empty())
      graph_.template_pose = file_.poses[0].name;
    if (!file_.poses.empty()) CheckTemplateIsScanned();
    if (file_.shot)
      for (const ShotRule::Shows& show : file_.shot->shows)
        CheckPose(file_, show.pose, "the shown pose");
    CheckShownFrames(file_, places_.project, disk_);
    graph_.name_given = file_.name.has_value();
    graph_.name = file_.name ? file_.name->text : places_.project.filename().string();
    graph_.poses = PoseOrder(file_, graph_.template_pose);
    graph_.timeline_json = file_.timeline_json;
    for (const TimelineKey& key : file_.timeline) graph_.keys.push_back(key.pose.text);
    if (graph_.keys.empty()) graph_.keys = graph_.poses;
    if (graph_.timeline_json.empty() && !performance)
      graph_.timeline_json = TimelineUnlessSaid(file_, overrides_, &graph_.keys);
    if (!performance) CheckPhotographs();
    CheckOptionSteps(file_, file_.options);
    for (const PoseRule& pose : file_.poses) CheckOptionSteps(file_, pose.options);
  }

  /// Whether there is something to do without poses: a step of the project that takes files.
  bool HasStepsOnFiles() const {
    const auto is_path = [](const Setting& reference) {
      return reference.text.starts_with("./") || reference.text.starts_with("/");
    };
    const auto takes_file = [&](const StepRule& rule) {
      return rule.enabled && rule.fan_out == FanOut::kProject &&
             std::any_of(rule.inputs.begin(), rule.inputs.end(), [&](const auto& input) {
               const std::vector<Setting>& references = input.second.for_template;
               return std::any_of(references.begin(), references.end(), is_path);
             });
    };
    return std::any_of(file_.steps.begin(), file_.steps.end(), takes_file);
  }

  void CheckTemplateIsScanned() const {
    const PoseRule& pose = *file_.FindPose(graph_.template_pose);
    if (pose.FoundBy() == Method::kScan) return;
    Fail(pose.method->where,
         fmt::format("pose '{}' is the template, the mesh that other poses are fitted with, so it "
                     "needs a scan from photographs all round; delete `method: fit` there, or make "
                     "another pose the template",
                     pose.name));
  }

  Sources Given() const { return {file_, disk_, places_.project, graph_.template_pose}; }

  void CheckPhotographs() const {
    const Sources sources = Given();
    const SourceRule* photos = sources.Find(kPhotosWord);
    if (!photos) return;
    std::vector<PhotoFolder> folders;
    for (const PoseRule& pose : file_.poses) {
      const auto path = sources.PathOf(*photos, &pose);
      if (!path) continue;
      folders.push_back({pose.name, (places_.project / sources.Located(*path)).lexically_normal()});
      if (!folders.back().folder.has_filename())
        folders.back().folder = folders.back().folder.parent_path();
    }
    if (SharedPhotographs(folders).empty()) return;
    // The message names the line of the first pose that shares photographs with an earlier one.
    std::vector<PhotoFolder> before;
    for (std::size_t i = 0; i < folders.size(); ++i) {
      before.push_back(folders[i]);
      if (const std::string fault = SharedPhotographs(before); !fault.empty())
        Fail(file_.FindPose(folders[i].pose)->where, fault);
    }
  }

  void LoadStages() {
    std::vector<fs::path> programs;
    for (const StepRule& rule : file_.steps) {
      if (rule.enabled && (MayExist(rule, Given(), file_.poses) || IsGivenOptions(rule)))
        programs.push_back(program_of_[rule.name] = ProgramOf(rule, places_, disk_));
    }
    catalog_.Load(programs);
  }

  bool IsGivenOptions(const StepRule& rule) const {
    const auto names = [&](const StepOptionSettings& given) { return given.count(rule.name) > 0; };
    return names(file_.options) ||
           std::any_of(file_.poses.begin(), file_.poses.end(),
                       [&](const PoseRule& pose) { return names(pose.options); });
  }

  void AddInstance(const StepRule& rule, const std::string& pose, const std::string& source_pose) {
    if (!IsWanted(rule, Given(), file_.FindPose(pose))) return;
    Step step;
    step.rule = rule.name;
    step.pose = pose;
    step.source_pose = source_pose;
    step.id = pose.empty() ? rule.name : rule.name + "/" + pose;
    step.program = program_of_.at(rule.name);
    step.is_own_program = rule.program.has_value();
    step.info = &catalog_.Get(step.program);
    step.cost = rule.cost;
    step.where = rule.where;
    graph_.steps.push_back(std::move(step));
    rule_of_.push_back(&rule);
  }

  /// Unless the step is only for poses that are found in another way.
  void AddPoseInstance(const StepRule& rule, const std::string& pose,
                       const std::string& source_pose) {
    const Method found_by = file_.FindPose(pose)->FoundBy();
    if (rule.method == StepMethod::kScan && found_by != Method::kScan) return;
    if (rule.method == StepMethod::kFit && found_by != Method::kFit) return;
    AddInstance(rule, pose, source_pose);
  }

  void MakeInstances() {
    for (const StepRule& rule : file_.steps) {
      if (!rule.enabled) continue;
      if (!rule.fan_out)
        Fail(
            rule.where,
            fmt::format("step '{}' needs `for:` with pose, template, pair, character, animation or "
                        "project",
                        rule.name));
      switch (*rule.fan_out) {
        case FanOut::kPose:
          for (const std::string& pose : graph_.poses) AddPoseInstance(rule, pose, "");
          break;
        case FanOut::kTemplate:
          if (!graph_.poses.empty()) AddInstance(rule, graph_.template_pose, "");
          break;
        case FanOut::kPair:
          for (std::size_t i = 1; i < graph_.poses.size(); ++i)
            AddPoseInstance(rule, graph_.poses[i], graph_.template_pose);
          break;
        case FanOut::kCharacter:
          if (!graph_.poses.empty()) AddInstance(rule, "", "");
          break;
        case FanOut::kAnimation:
          if (graph_.poses.size() > 1) AddInstance(rule, "", "");
          break;
        case FanOut::kProject:
          AddInstance(rule, "", "");
          break;
      }
    }
  }

  /// The value of a word that begins with $ where an option's value is expected.
  std::string OptionText(const std::string& text) const {
    if (text == "$fps") return fmt::format("{}", file_.fps);
    if (text == "$film_fps") return fmt::format("{}", file_.shot ? file_.shot->fps : file_.fps);
    if (text == "$shows") {
      std::string shows;
      for (std::size_t i = 0; file_.shot && i < file_.shot->shows.size(); ++i)
        shows += fmt::format("{}{}={}", i ? "," : "", file_.shot->shows[i].frame,
                             file_.shot->shows[i].pose.text);
      return shows;
    }
    return text == "$keys" ? fmt::format("{}", fmt::join(graph_.keys, ",")) : text;
  }

  void SetOption(Step* step, const std::string& name, const std::string& text,
                 const Where& where) const {
    try {
      step->options[name] = CanonicalOption(OptionOf(*step->info, name), OptionText(text));
    } catch (const UsageError& error) {
      Fail(where, fmt::format("step '{}': {}", step->rule, error.what()));
    }
  }

  /// All options in the project are checked, also those of steps that it has no instance of: who
  /// gives them expects an answer now, not on the day when a pose of few photographs or a film is
  /// added.
  void CheckGivenOptions() const {
    std::vector<const StepOptionSettings*> all = {&file_.options};
    for (const PoseRule& pose : file_.poses) all.push_back(&pose.options);
    for (const StepOptionSettings* given : all)
      for (const auto& [name, settings] : *given)
        if (file_.FindStep(name)->enabled) CheckOptionsOf(name, settings.options);
  }

  void CheckOptionsOf(const std::string& rule, const OptionSettings& settings) const {
    Step step;
    step.rule = rule;
    step.info = &catalog_.Get(program_of_.at(rule));
    for (const auto& [option, value] : settings) SetOption(&step, option, value.text, value.where);
  }

  void SetOptions(const StepRule& rule, Step* step) const {
    for (const OptionInfo& option : step->info->options)
      step->options[option.name] = option.default_value;
    const auto apply = [&](const OptionSettings& settings) {
      for (const auto& [name, value] : settings) SetOption(step, name, value.text, value.where);
    };
    apply(rule.options);
    const PoseRule* pose = file_.FindPose(step->pose);
    const bool fitted = pose && pose->FoundBy() == Method::kFit;
    apply(fitted ? rule.fit_options : rule.scan_options);
    if (const auto it = file_.options.find(step->rule); it != file_.options.end())
      apply(it->second.options);
    if (pose) {
      if (const auto it = pose->options.find(step->rule); it != pose->options.end())
        apply(it->second.options);
    }
    for (const Override& over : overrides_) {
      if (over.step != step->rule || (!over.pose.empty() && over.pose != step->pose)) continue;
      try {
        step->options[over.option] =
            CanonicalOption(OptionOf(*step->info, over.option), over.value);
      } catch (const UsageError& error) {
        throw UsageError(
            fmt::format("--set {}.{}={}: {}", over.step, over.option, over.value, error.what()));
      }
    }
  }

  /// A path below out/ with its pose placeholders replaced.
  std::string WithNames(std::string path, const Step& step) const {
    for (const auto& [word, value] : {std::pair<std::string, std::string>{"{pose}", step.pose},
                                      {"{shot}", step.pose},
                                      {"{template}", graph_.template_pose}}) {
      for (std::size_t at; (at = path.find(word)) != std::string::npos;)
        path.replace(at, word.size(), value);
    }
    return path;
  }

  void SetShown(const StepRule& rule, Step* step) const {
    for (const ShownSetting& shown : rule.show) {
      const fs::path path = fs::path(WithNames(shown.path.text, *step)).lexically_normal();
      const auto holds = [&](const NamedResult& result) { return IsWithin(path, result.path); };
      if (std::none_of(step->results.begin(), step->results.end(), holds))
        Fail(shown.path.where,
             fmt::format("step '{}' shows {}, which is not among its results (`out`)", step->rule,
                         path.string()));
      step->shown.push_back({path, shown.label});
    }
  }

  void SetResults(const StepRule& rule, Step* step) const {
    for (const auto& [port_text, path_text] : rule.out) {
      const auto slash = port_text.find('/');
      NamedResult result;
      result.port = port_text.substr(0, slash);
      if (slash != std::string::npos) result.inside = port_text.substr(slash + 1);
      result.where = path_text.where;
      const PortInfo* port = step->info->FindOutput(result.port);
      std::vector<std::string> known;
      for (const PortInfo& output : step->info->outputs) known.push_back(output.name);
      if (!port)
        Fail(result.where,
             fmt::format("step '{}': stage '{}' has no output '{}'{}", step->rule,
                         step->info->stage, result.port, Suggestion(result.port, known)));
      const std::string path = WithNames(path_text.text, *step);
      result.path = fs::path(path).lexically_normal();
      const bool inside_out = !path.empty() && !result.path.is_absolute() &&
                              *result.path.begin() != ".." && result.path != ".";
      if (!inside_out)
        Fail(result.where, fmt::format("step '{}': the result path '{}' must lie inside out/",
                                       step->rule, path_text.text));
      step->results.push_back(std::move(result));
    }
  }

  void CheckResults() const {
    std::vector<std::pair<const Step*, const NamedResult*>> all;
    for (const Step& step : graph_.steps) {
      for (const NamedResult& result : step.results) all.emplace_back(&step, &result);
    }
    // Sorted by path, the contents of a folder come right after it.
    std::stable_sort(all.begin(), all.end(),
                     [](const auto& a, const auto& b) { return a.second->path < b.second->path; });
    for (std::size_t i = 1; i < all.size(); ++i) {
      const auto& [first, outer] = all[i - 1];
      const auto& [second, inner] = all[i];
      if (!IsWithin(inner->path, outer->path)) continue;
      Fail(inner->where,
           fmt::format("two steps write one result: {} and {} both write out/{} (the other at {}); "
                       "give one of them another path",
                       first->id, second->id, inner->path.generic_string(), outer->where.Text()));
    }
  }

  void CheckOverrides() const {
    for (const Override& over : overrides_)
      graph_.Find(over.pose.empty() ? over.step : over.step + "/" + over.pose);
  }

  /// Depth first: every step comes after the steps that it needs, and cycles are found.
  void SortByNeeds() {
    std::vector<int> order, path, state(graph_.steps.size(), 0);
    const std::function<void(int)> visit = [&](int i) {
      if (state[i] == 2) return;
      if (state[i] == 1) FailCycle(i, path);
      state[i] = 1;
      path.push_back(i);
      for (const int need : graph_.steps[i].needs) visit(need);
      path.pop_back();
      state[i] = 2;
      order.push_back(i);
    };
    for (std::size_t i = 0; i < graph_.steps.size(); ++i) visit(static_cast<int>(i));
    std::vector<int> new_index(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) new_index[order[i]] = static_cast<int>(i);
    std::vector<Step> sorted;
    for (const int i : order) sorted.push_back(std::move(graph_.steps[i]));
    for (Step& step : sorted) {
      for (int& need : step.needs) need = new_index[need];
      std::sort(step.needs.begin(), step.needs.end());
      for (PortFlows& port : step.inputs) {
        for (Flow& flow : port.flows) {
          if (flow.step >= 0) flow.step = new_index[flow.step];
        }
      }
    }
    graph_.steps = std::move(sorted);
  }

  [[noreturn]] void FailCycle(int again, const std::vector<int>& path) const {
    std::vector<std::string> names;
    for (auto it = std::find(path.begin(), path.end(), again); it != path.end(); ++it)
      names.push_back(graph_.steps[*it].id);
    names.push_back(graph_.steps[again].id);
    std::reverse(names.begin(), names.end());
    Fail(graph_.steps[again].where,
         fmt::format("the steps form a cycle: {}; one of them must take its input from elsewhere",
                     fmt::join(names, " -> ")));
  }

  const PipelineFile& file_;
  const std::vector<Override>& overrides_;
  const Places& places_;
  const Disk& disk_;
  StageCatalog& catalog_;
  Graph graph_;
  std::vector<const StepRule*> rule_of_;
  std::map<std::string, fs::path> program_of_;
};

}  // namespace

Override ParseOverride(const std::string& text) {
  const auto equals = text.find('=');
  const auto dot = text.find('.');
  if (equals == std::string::npos || dot == std::string::npos || dot > equals || dot == 0 ||
      dot + 1 == equals) {
    throw UsageError(
        fmt::format("--set {}: write it as STEP.OPTION=VALUE or STEP/POSE.OPTION=VALUE", text));
  }
  Override result;
  const std::string step = Composed(text.substr(0, dot));
  const auto slash = step.find('/');
  result.step = step.substr(0, slash);
  if (slash != std::string::npos) result.pose = step.substr(slash + 1);
  result.option = text.substr(dot + 1, equals - dot - 1);
  result.value = text.substr(equals + 1);
  return result;
}

Graph BuildGraph(const PipelineFile& file, const std::vector<Override>& overrides,
                 const Places& places, const Disk& disk, StageCatalog& catalog) {
  return GraphBuilder(file, overrides, places, disk, catalog).Build();
}

}  // namespace keypose::pipeline
