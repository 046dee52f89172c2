#include "pipeline/run/plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/numbers/sha256.h"
#include "core/values/errors.h"

namespace keypose::pipeline {
namespace {

using State = StepPlan::State;

std::vector<bool> Marked(const Graph& graph, const std::vector<std::string>& selectors) {
  std::vector<bool> marked(graph.steps.size(), false);
  for (const std::string& selector : selectors) {
    for (const int i : graph.Find(selector)) marked[i] = true;
  }
  return marked;
}

/// The marked steps and all that depend on them.
std::vector<bool> WithFollowers(const Graph& graph, std::vector<bool> marked) {
  for (std::size_t i = 0; i < graph.steps.size(); ++i) {
    for (const int need : graph.steps[i].needs) marked[i] = marked[i] || marked[need];
  }
  return marked;
}

/// The marked steps and all steps that they need.
std::vector<bool> WithNeeds(const Graph& graph, std::vector<bool> marked) {
  for (std::size_t i = graph.steps.size(); i-- > 0;) {
    if (!marked[i]) continue;
    for (const int need : graph.steps[i].needs) marked[need] = true;
  }
  return marked;
}

/// What a timeline says, by the words of pipeline.yaml; long lists are only told apart.
std::map<std::string, std::string> TimelineSettings(const std::string& text) {
  constexpr std::size_t kShown = 60;
  std::map<std::string, std::string> settings;
  const auto add = [&](const std::string& name, const nlohmann::json& value) {
    const std::string all = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    settings[name] = all.size() <= kShown
                         ? all
                         : fmt::format("{}... ({:.6})", all.substr(0, kShown), Sha256Of(all));
  };
  const nlohmann::json timeline = nlohmann::json::parse(text);
  for (const auto& [name, value] : timeline.items()) {
    if (name != "keys" && name != "schema") add(name, value);
  }
  int number = 0;
  for (nlohmann::json key : timeline.at("keys")) {
    if (key.contains("time")) key["at"] = key["time"];
    key.erase("time");
    add(fmt::format("key {}", number++), key);
  }
  return settings;
}

}  // namespace

Plan::Plan(const Graph& graph, Workshop& workshop, const Selection& selection)
    : graph_(graph), workshop_(workshop), steps_(graph.steps.size()) {
  Select(selection);
  CheckSources();
  for (std::size_t i = 0; i < steps_.size(); ++i)
    steps_[i].last = workshop_.records.Last(graph_.steps[i].id);
  Advance();
}

void Plan::Select(const Selection& selection) {
  std::vector<bool> wanted(steps_.size(), true);
  const auto narrow = [&](const std::vector<bool>& to) {
    for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] = wanted[i] && to[i];
  };
  if (!selection.from.empty()) narrow(WithFollowers(graph_, Marked(graph_, selection.from)));
  if (!selection.until.empty()) narrow(WithNeeds(graph_, Marked(graph_, selection.until)));
  if (!selection.only.empty()) narrow(Marked(graph_, selection.only));
  const std::vector<bool> forced = Marked(graph_, selection.force);
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    steps_[i].wanted = wanted[i];
    steps_[i].forced = wanted[i] && forced[i];
  }
}

void Plan::CheckSources() const {
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    if (!steps_[i].wanted) continue;
    for (const PortFlows& port : graph_.steps[i].inputs) {
      for (const Flow& flow : port.flows) {
        if (flow.kind != Flow::Kind::kSource) continue;
        const auto stat = workshop_.disk.Stat(SourceOf(flow));
        const std::string start = fmt::format("{}: step '{}' reads {}, ", flow.where.Text(),
                                              graph_.steps[i].id, flow.origin);
        if (!stat)
          throw InputError(start +
                           fmt::format("which does not exist; put it at {}, or correct the line",
                                       SourceOf(flow).string()));
        const bool wants_folder = port.kind == PortKind::kFolder;
        if (port.kind == PortKind::kEither || stat->folder == wants_folder) continue;
        throw InputError(start + fmt::format("which is a {}, but '{}' must be a {}",
                                             stat->folder ? "folder" : "file", port.port,
                                             wants_folder ? "folder" : "file"));
      }
    }
  }
}

std::filesystem::path Plan::SourceOf(const Flow& flow) const {
  if (flow.kind == Flow::Kind::kSource) return (workshop_.project / flow.path).lexically_normal();
  if (flow.kind == Flow::Kind::kOutput) return steps_[flow.step].artifact->Path(flow.port);
  return {};
}

void Plan::Advance() {
  for (int i = 0; i < size(); ++i) {
    StepPlan& step = steps_[i];
    if (step.state != State::kWaiting) continue;
    bool known = true, missing = false;
    for (const int need : graph_.steps[i].needs) {
      const State state = steps_[need].state;
      known = known && (state == State::kDone || state == State::kMissing);
      missing = missing || state == State::kMissing;
    }
    if (!known) continue;
    if (!missing) {
      Resolve(i);
    } else if (!step.wanted && !TakeLastMade(i)) {
      step.state = State::kMissing;
    }
  }
  CheckMissing();
}

void Plan::Resolve(int i) {
  StepPlan& step = steps_[i];
  if (!step.wanted) {
    for (const PortFlows& port : graph_.steps[i].inputs) {
      for (const Flow& flow : port.flows) {
        // A missing source does not matter for a step that is not to run.
        if (flow.kind == Flow::Kind::kSource && !workshop_.disk.Stat(SourceOf(flow))) {
          if (!TakeLastMade(i)) step.state = State::kMissing;
          return;
        }
      }
    }
  }
  step.recipe = MakeRecipe(i);
  step.fingerprint = step.recipe.Fingerprint();
  std::string damage;
  step.artifact = workshop_.store.Find(step.fingerprint, &damage);
  if (step.artifact && !step.forced) {
    step.state = State::kDone;
  } else if (step.wanted) {
    step.state = State::kReady;
    step.reasons = ReasonsOf(step);
    if (!damage.empty())
      step.reasons = {
          fmt::format("its artifact in the cache was damaged from outside ({})", damage)};
    step.artifact.reset();
  } else if (!TakeLastMade(i)) {
    step.state = State::kMissing;
  }
}

bool Plan::TakeLastMade(int i) {
  StepPlan& step = steps_[i];
  if (!step.last || step.last->fingerprint.empty()) return false;
  step.artifact = workshop_.store.Find(step.last->fingerprint);
  if (!step.artifact) return false;
  step.recipe = step.artifact->recipe;
  step.fingerprint = step.artifact->fingerprint;
  step.state = State::kDone;
  return true;
}

Recipe Plan::MakeRecipe(int i) const {
  const Step& step = graph_.steps[i];
  Recipe recipe{step.info->stage, step.info->version, step.info->tools, step.options, {}};
  for (const PortFlows& port : step.inputs) {
    for (const Flow& flow : port.flows)
      recipe.inputs.push_back({port.port, flow.origin, ContentOf(flow, i)});
  }
  return recipe;
}

Content Plan::ContentOf(const Flow& flow, int i) const {
  switch (flow.kind) {
    case Flow::Kind::kSource:
      return workshop_.hasher.Of(SourceOf(flow));
    case Flow::Kind::kTimeline:
      return {Sha256Of(graph_.timeline_json), {}, TimelineSettings(graph_.timeline_json)};
    case Flow::Kind::kOutput: {
      const auto& outputs = steps_[flow.step].artifact->outputs;
      const auto it = outputs.find(flow.port);
      if (it == outputs.end())
        throw ToolError(
            fmt::format("{}: {} was not written by its step", flow.where.Text(), flow.origin));
      return it->second.content;
    }
    case Flow::Kind::kRun:
      break;
  }
  std::map<std::string, std::string> results;
  results["the project's name and keys"] =
      Sha256Of((graph_.name_given ? graph_.name : "") + "\n" +
               fmt::format("{}\n{}", fmt::join(graph_.keys, " "), graph_.timeline_json));
  for (const int need : graph_.steps[i].needs) {
    std::string text = steps_[need].fingerprint;
    for (const auto& [port, output] : steps_[need].artifact->outputs)
      text += port + output.content.hash;
    results[graph_.steps[need].id] = Sha256Of(text);
  }
  return FolderContent(std::move(results));
}

std::vector<std::string> Plan::ReasonsOf(const StepPlan& step) const {
  std::vector<std::string> reasons;
  if (step.forced) reasons.push_back("--force was given");
  if (!step.last) {
    reasons.push_back("it has never run");
    return reasons;
  }
  const StepRecord& last = *step.last;
  if (last.failed && last.failed_fingerprint == step.fingerprint) {
    reasons.push_back("its last try failed");
  }
  if (last.fingerprint.empty()) {
    if (reasons.empty()) reasons.push_back("it has never succeeded");
    return reasons;
  }
  for (std::string& difference : Differences(last.recipe, step.recipe))
    reasons.push_back(std::move(difference));
  if (reasons.empty()) reasons.push_back("its artifact is no longer in the cache");
  return reasons;
}

void Plan::CheckMissing() const {
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    if (!steps_[i].wanted || steps_[i].state != State::kWaiting) continue;
    for (const int need : graph_.steps[i].needs) {
      if (steps_[need].state != State::kMissing) continue;
      const Step& step = graph_.steps[need];
      throw UsageError(
          fmt::format("{} needs {}, which was not selected and has not been made yet; run `keypose "
                      "run --until {}` first, or leave out --from and --only",
                      graph_.steps[i].id, step.id, step.rule));
    }
  }
}

std::vector<int> Plan::Ready() const {
  std::vector<int> ready;
  for (int i = 0; i < size(); ++i) {
    if ((*this)[i].state == State::kReady) ready.push_back(i);
  }
  return ready;
}

void Plan::SetDone(int i, Artifact artifact, bool made) {
  StepPlan& step = steps_[i];
  step.artifact = std::move(artifact);
  step.made = made;
  step.state = State::kDone;
  Advance();
}

std::vector<std::string> Plan::WaitsFor(int i) const {
  std::vector<std::string> ids;
  for (const int need : graph_.steps[i].needs) {
    if (steps_[need].state != State::kDone) ids.push_back(graph_.steps[need].id);
  }
  return ids;
}

namespace {

nlohmann::json MeasurementsJson(const StageInfo& info) {
  nlohmann::json list = nlohmann::json::array();
  for (const MeasurementInfo& one : info.measurements) {
    nlohmann::json described = {{"key", one.key}, {"label", one.label}, {"unit", one.unit}};
    if (one.good_min) described["good"]["min"] = *one.good_min;
    if (one.good_max) described["good"]["max"] = *one.good_max;
    list.push_back(described);
  }
  return list;
}

}  // namespace

std::string Plan::RunJson(int i) const {
  using nlohmann::json;
  json steps = json::array();
  for (const int need : graph_.steps[i].needs) {
    const Step& step = graph_.steps[need];
    const StepPlan& plan = steps_[need];
    json outputs = json::object(), inputs = json::object();
    for (const auto& [port, output] : plan.artifact->outputs)
      outputs[port] = plan.artifact->Path(port).string();
    for (const PortFlows& port : step.inputs) {
      for (const Flow& flow : port.flows) {
        if (const auto path = SourceOf(flow); !path.empty())
          inputs[port.port].push_back(path.string());
      }
    }
    steps.push_back({{"id", step.id},
                     {"step", step.rule},
                     {"stage", step.info->stage},
                     {"title", step.info->title},
                     {"described", MeasurementsJson(*step.info)},
                     {"pose", step.pose},
                     {"source_pose", step.source_pose},
                     {"status", "done"},
                     {"seconds", plan.artifact->seconds},
                     {"peak_bytes", plan.artifact->peak_bytes},
                     {"cached", !plan.made},
                     {"fingerprint", plan.fingerprint},
                     {"options", plan.recipe.options},
                     {"report", (plan.artifact->folder / "report.json").string()},
                     {"outputs", outputs},
                     {"inputs", inputs}});
  }
  // The content of $timeline, or the order of poses if the file gives no more.
  json timeline = graph_.timeline_json.empty() ? json{{"schema", 1}, {"keys", json::array()}}
                                               : json::parse(graph_.timeline_json);
  if (graph_.timeline_json.empty()) {
    for (const std::string& key : graph_.keys) timeline["keys"].push_back({{"pose", key}});
  }
  json project = {
      {"name", graph_.name}, {"template", graph_.template_pose}, {"poses", graph_.poses}};
  // Not said of projects of poses: what is said changes the report's fingerprint.
  if (graph_.kind == ProjectKind::kPerformance) project["kind"] = "performance";
  return json{{"schema", 1}, {"project", project}, {"timeline", timeline}, {"steps", steps}}.dump(
      1);
}

}  // namespace keypose::pipeline
