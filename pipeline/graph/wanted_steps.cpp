#include "pipeline/graph/wanted_steps.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/values/errors.h"
#include "pipeline/graph/stage_info.h"

namespace keypose::pipeline {
namespace {

void RequireWord(const StepRule& rule, const Setting& reference, const Sources& sources,
                 const PoseRule* pose) {
  const std::string& text = reference.text;
  std::string fault;
  if (!text.starts_with("$"))
    fault = fmt::format("`when` takes words such as $scan, not '{}'", text);
  else if (!sources.Knows(text.substr(1)))
    fault = fmt::format("'{}' is not known{}", text, Suggestion(text, sources.Words()));
  else if (sources.IsOfPose(text.substr(1)) && !pose)
    fault = fmt::format("the step is not of one pose, so it has no {}", text);
  if (!fault.empty())
    throw UsageError(fmt::format("{}: step '{}': {}", reference.where.Text(), rule.name, fault));
}

}  // namespace

bool MayExist(const StepRule& rule, const Sources& sources, const std::vector<PoseRule>& poses) {
  return std::all_of(rule.when.begin(), rule.when.end(), [&](const Setting& reference) {
    if (!reference.text.starts_with("$")) return true;
    const std::string word = reference.text.substr(1);
    // What is no word is told of where the steps are made.
    if (!sources.Knows(word)) return true;
    if (!sources.IsOfPose(word)) return sources.Gives(word, nullptr);
    return std::any_of(poses.begin(), poses.end(),
                       [&](const PoseRule& pose) { return sources.Gives(word, &pose); });
  });
}

bool IsWanted(const StepRule& rule, const Sources& sources, const PoseRule* pose) {
  return std::all_of(rule.when.begin(), rule.when.end(), [&](const Setting& reference) {
    RequireWord(rule, reference, sources, pose);
    return sources.Gives(reference.text.substr(1), pose);
  });
}

}  // namespace keypose::pipeline
