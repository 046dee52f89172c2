#include "pipeline/graph/pipeline_overlay.h"

#include <algorithm>

namespace keypose::pipeline {
namespace {

void OverlayStep(const StepRule& over, StepRule* step) {
  step->enabled = over.enabled;
  step->where = over.where;
  // A program replaces the stage, and a stage replaces the program.
  if (over.stage || over.program) {
    step->stage = over.stage;
    step->program = over.program;
  }
  if (over.fan_out) step->fan_out = over.fan_out;
  if (over.method) step->method = over.method;
  if (!over.when.empty()) step->when = over.when;
  for (const auto& [port, rule] : over.inputs) step->inputs[port] = rule;
  const auto overlay = [](const OptionSettings& from, OptionSettings& to) {
    for (const auto& [name, value] : from) to[name] = value;
  };
  // What is said for all poses replaces what the default says for those of one method.
  for (const auto& [name, value] : over.options) {
    step->scan_options.erase(name);
    step->fit_options.erase(name);
  }
  overlay(over.options, step->options);
  overlay(over.scan_options, step->scan_options);
  overlay(over.fit_options, step->fit_options);
  for (const auto& [port, path] : over.out) step->out[port] = path;
  if (!over.show.empty()) step->show = over.show;
  if (over.cost || over.stage || over.program) step->cost = over.cost;
}

}  // namespace

PipelineFile Overlay(const PipelineFile& defaults, const PipelineFile& project) {
  PipelineFile result = project;
  result.sources = defaults.sources;
  result.sources.insert(result.sources.end(), project.sources.begin(), project.sources.end());
  // So that a misspelt key of the default pipeline is found.
  result.given.insert(result.given.begin(), defaults.given.begin(), defaults.given.end());
  if (!result.default_timeline) result.default_timeline = defaults.default_timeline;
  result.steps = defaults.steps;
  for (const StepRule& over : project.steps) {
    const auto it = std::find_if(result.steps.begin(), result.steps.end(),
                                 [&](const StepRule& step) { return step.name == over.name; });
    if (it == result.steps.end()) {
      result.steps.push_back(over);
    } else {
      OverlayStep(over, &*it);
    }
  }
  return result;
}

}  // namespace keypose::pipeline
