#include "pipeline/cache/ending.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// `head` followed by the text, with continuation lines indented to the width of `head`.
std::string Hanging(const std::string& head, const std::string& text, std::size_t columns) {
  constexpr std::size_t kNarrowest = 24;
  const std::size_t indent = WidthOf(head);
  const std::size_t width =
      columns == 0 ? 0 : std::max(kNarrowest, columns > indent ? columns - indent : 0);
  std::string lines;
  for (const std::string& line : Wrapped(text, width))
    lines += (lines.empty() ? head : std::string(indent, ' ')) + line + "\n";
  return lines;
}

std::string PaddedTo(const std::string& text, std::size_t columns) {
  const std::size_t width = WidthOf(text);
  return text + std::string(columns > width ? columns - width : 0, ' ');
}

/// "sfm" of sfm/rest and sfm/bent.
std::string RulesOf(const RunWarning& warning) {
  std::vector<std::string> rules;
  for (const std::string& step : warning.steps) {
    const std::string rule = step.substr(0, step.find('/'));
    if (std::find(rules.begin(), rules.end(), rule) == rules.end()) rules.push_back(rule);
  }
  return fmt::format("{}", fmt::join(rules, ", "));
}

std::string PosesOf(const RunWarning& warning) {
  return warning.poses.empty() ? "all poses together"
                               : fmt::format("{}", fmt::join(warning.poses, ", "));
}

}  // namespace

std::string WarningCount(const Ending& ending) {
  return fmt::format("{} warning{}", ending.warnings.size(),
                     ending.warnings.size() == 1 ? "" : "s");
}

std::string WarningsText(const Ending& ending, std::size_t columns) {
  if (ending.warnings.empty()) return "";
  std::vector<std::string> groups;
  for (const RunWarning& warning : ending.warnings) {
    const std::string group = PosesOf(warning);
    if (std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
  }
  std::string text = WarningCount(ending) + "\n";
  for (const std::string& group : groups) {
    text += "  " + group + "\n";
    for (const RunWarning& warning : ending.warnings) {
      if (PosesOf(warning) == group)
        text += Hanging("    " + RulesOf(warning) + ": ", warning.text, columns);
    }
  }
  return text;
}

namespace {

/// What fits into a line, without the begin of a word; not less than the head.
std::string CutAtAWord(const std::string& text, std::size_t columns, std::size_t head) {
  std::string cut = CutTo(text, columns);
  const bool within = cut.size() < text.size() && text[cut.size()] != ' ';
  const std::size_t space = cut.find_last_of(' ');
  if (within && space != std::string::npos && space > head) cut.erase(space);
  while (cut.size() > head && cut.ends_with(' ')) cut.pop_back();
  return cut;
}

}  // namespace

std::string VerdictsText(const Ending& ending, std::size_t columns, bool whole) {
  if (ending.verdicts.empty()) return "";
  std::size_t about = 0, grade = 0;
  for (const RunVerdict& verdict : ending.verdicts) {
    about = std::max(about, WidthOf(verdict.about));
    grade = std::max(grade, WidthOf(verdict.grade));
  }
  std::string text = "verdicts\n";
  bool cut = false;
  for (const RunVerdict& verdict : ending.verdicts) {
    const std::string head =
        "  " + PaddedTo(verdict.about, about) + "  " + PaddedTo(verdict.grade, grade) + "  ";
    const bool fits = columns == 0 || whole || WidthOf(head + verdict.why) < columns;
    cut = cut || !fits;
    text += fits ? Hanging(head, verdict.why, columns)
                 : CutAtAWord(head + verdict.why, columns - 2, head.size()) + "\u2026\n";
  }
  return cut ? text + "  the whole of it: keypose status --details\n" : text;
}

std::string ResultsText(const Ending& ending) {
  if (ending.results.empty()) return "";
  std::size_t label = 0;
  for (const RunFound& result : ending.results) label = std::max(label, WidthOf(result.label));
  std::string text = "results\n";
  // Not wrapped, so that paths can be copied.
  for (const RunFound& result : ending.results)
    text += "  " + PaddedTo(result.label, label) + "  " + result.path.string() + "\n";
  return text;
}

json ToJson(const RunWarning& warning) {
  return {{"steps", warning.steps}, {"poses", warning.poses}, {"text", warning.text}};
}

json ToJson(const RunVerdict& verdict) {
  return {{"about", verdict.about},
          {"grade", verdict.grade},
          {"why", verdict.why},
          {"step", verdict.step}};
}

json ToJson(const RunFound& result) {
  return {{"label", result.label}, {"path", result.path.string()}, {"step", result.step}};
}

}  // namespace keypose::pipeline
