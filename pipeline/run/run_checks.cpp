#include "pipeline/run/run_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/io/project/timeline_json.h"
#include "core/values/errors.h"
#include "pipeline/graph/shown_frames.h"

namespace keypose::pipeline {
namespace {

bool MayRun(const StepPlan& step) { return step.wanted && step.state != StepPlan::State::kDone; }

/// Whether a step that may run takes something of this kind, or from this place.
bool Takes(const Plan& plan, Flow::Kind kind, const std::string& origin = "") {
  for (int i = 0; i < plan.size(); ++i) {
    if (!MayRun(plan[i])) continue;
    for (const PortFlows& port : plan.graph().steps[i].inputs)
      for (const Flow& flow : port.flows)
        if (flow.kind == kind && (origin.empty() || flow.origin == origin)) return true;
  }
  return false;
}

void RequirePlayableTimeline(const Plan& plan, const PipelineFile& file) {
  if (file.timeline_json.empty() || !Takes(plan, Flow::Kind::kTimeline)) return;
  try {
    RequirePlayable(ParseTimeline(file.timeline_json, "timeline"), "timeline");
  } catch (const TimelineError& error) {
    const TimelineKey& key = file.timeline[static_cast<std::size_t>(std::max(error.key, 0))];
    throw UsageError(fmt::format("{}: {}", key.pose.where.Text(), error.what()));
  }
}

/// Whether planning could not check the value: more than one of some words.
bool OnlyItsStageKnows(const OptionInfo& option) {
  return option.type != "bool" && option.choices.empty();
}

/// The question to the step's stage; empty if there is nothing to ask.
std::vector<std::string> QuestionOf(const Step& step) {
  std::vector<std::string> question = {step.program.string(), "--check_options"};
  bool asks = false;
  for (const OptionInfo& option : step.info->options) {
    const std::string& value = step.options.at(option.name);
    if (value == option.default_value) continue;
    asks = asks || OnlyItsStageKnows(option);
    question.insert(question.end(), {"--" + option.name, value});
  }
  return asks && !step.is_own_program ? question : std::vector<std::string>();
}

/// What a stage says of its options, without who says it.
std::string Fault(const std::string& said, const std::string& stage) {
  const std::string start = fmt::format("keypose {}: error: ", stage);
  std::string fault = said.starts_with(start) ? said.substr(start.size()) : said;
  while (!fault.empty() && fault.back() == '\n') fault.pop_back();
  return fault;
}

/// A stage of an older version does not know the question: its run will tell.
bool Refuses(const ProcessRunner::Answer& answer) {
  return answer.exit_code == static_cast<int>(ExitCode::kUsage) &&
         answer.error.find("--check_options") == std::string::npos;
}

void AskStages(const Plan& plan, ProcessRunner& processes) {
  constexpr std::size_t kAtOnce = 16;
  std::map<std::vector<std::string>, const Step*> asked;  // steps with equal options are one
  for (int i = 0; i < plan.size(); ++i) {
    if (!MayRun(plan[i])) continue;
    const Step& step = plan.graph().steps[i];
    if (std::vector<std::string> question = QuestionOf(step); !question.empty())
      asked.emplace(std::move(question), &step);
  }
  std::vector<std::vector<std::string>> questions;
  std::vector<const Step*> steps;
  const auto ask = [&] {
    const std::vector<ProcessRunner::Answer> answers = processes.Ask(questions);
    for (std::size_t i = 0; i < answers.size(); ++i)
      if (Refuses(answers[i]))
        throw UsageError(fmt::format("options of step '{}': {}", steps[i]->id,
                                     Fault(answers[i].error, steps[i]->info->stage)));
    questions.clear();
    steps.clear();
  };
  for (const auto& [question, step] : asked) {
    questions.push_back(question);
    steps.push_back(step);
    if (questions.size() == kAtOnce) ask();
  }
  if (!questions.empty()) ask();
}

}  // namespace

void RequireRunnable(const Plan& plan, const PipelineFile& file, ProcessRunner& processes) {
  RequirePlayableTimeline(plan, file);
  if (Takes(plan, Flow::Kind::kTimeline)) CheckShownTimes(file);
  AskStages(plan, processes);
}

}  // namespace keypose::pipeline
