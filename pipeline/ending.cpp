#include "pipeline/ending.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "pipeline/plan.h"
#include "pipeline/text.h"

namespace keypose::pipeline {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

std::string TextAt(const json& object, const char* field) {
  const auto it = object.find(field);
  return it != object.end() && it->is_string() ? it->get<std::string>() : "";
}

json ReportOf(const Artifact& artifact, const Disk& disk) {
  const fs::path file = artifact.folder / "report.json";
  const auto stat = disk.Stat(file);
  if (!stat || stat->folder) return json::object();
  const json report = json::parse(disk.Read(file), nullptr, false);
  return report.is_object() ? report : json::object();
}

void AddWarnings(const json& report, const Step& step, std::vector<RunWarning>* warnings) {
  const auto list = report.find("warnings");
  if (list == report.end() || !list->is_array()) return;
  const auto add = [](const std::string& name, std::vector<std::string>* names) {
    if (!name.empty() && std::find(names->begin(), names->end(), name) == names->end()) names->push_back(name);
  };
  for (const json& text : *list) {
    if (!text.is_string() || text.get<std::string>().empty()) continue;
    auto same = std::find_if(warnings->begin(), warnings->end(), [&](const RunWarning& warning) { return warning.text == text; });
    if (same == warnings->end()) same = warnings->insert(same, {{}, {}, text.get<std::string>()});
    add(step.id, &same->steps);
    add(step.pose, &same->poses);
  }
}

void AddVerdicts(const json& report, const Step& step, std::vector<RunVerdict>* verdicts) {
  const auto list = report.find("verdicts");
  if (list == report.end() || !list->is_array()) return;
  for (const json& item : *list) {
    if (!item.is_object() || TextAt(item, "about").empty()) continue;
    const RunVerdict verdict{TextAt(item, "about"), TextAt(item, "grade"), TextAt(item, "why"), step.id};
    const auto same = [&](const RunVerdict& other) {
      return other.about == verdict.about && other.grade == verdict.grade && other.why == verdict.why;
    };
    if (std::none_of(verdicts->begin(), verdicts->end(), same)) verdicts->push_back(verdict);
  }
}

void SortByPose(const std::vector<std::string>& poses, std::vector<RunVerdict>* verdicts) {
  const auto rank = [&](const RunVerdict& verdict) { return std::find(poses.begin(), poses.end(), verdict.about) - poses.begin(); };
  std::stable_sort(verdicts->begin(), verdicts->end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
}

/// `head`, then the text beside it, its further lines below its first.
std::string Hanging(const std::string& head, const std::string& text, std::size_t columns) {
  constexpr std::size_t kNarrowest = 24;
  const std::size_t indent = WidthOf(head);
  const std::size_t width = columns == 0 ? 0 : std::max(kNarrowest, columns > indent ? columns - indent : 0);
  std::string lines;
  for (const std::string& line : Wrapped(text, width)) lines += (lines.empty() ? head : std::string(indent, ' ')) + line + "\n";
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
  return warning.poses.empty() ? "all poses together" : fmt::format("{}", fmt::join(warning.poses, ", "));
}

}  // namespace

Ending EndingOf(const Plan& plan, const Disk& disk, const fs::path& out) {
  Ending ending;
  for (int i = 0; i < plan.size(); ++i) {
    if (!plan[i].wanted || plan[i].state != StepPlan::State::kDone) continue;
    const Step& step = plan.graph().steps[static_cast<std::size_t>(i)];
    const json report = ReportOf(*plan[i].artifact, disk);
    AddWarnings({{"warnings", step.warnings}}, step, &ending.warnings);
    AddWarnings(report, step, &ending.warnings);
    AddVerdicts(report, step, &ending.verdicts);
    for (const ShownResult& shown : step.shown) {
      const fs::path path = out / shown.path;
      if (disk.Stat(path)) ending.results.push_back({shown.label, path, step.id});
    }
  }
  SortByPose(plan.graph().poses, &ending.verdicts);
  return ending;
}

std::string WarningCount(const Ending& ending) {
  return fmt::format("{} warning{}", ending.warnings.size(), ending.warnings.size() == 1 ? "" : "s");
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
      if (PosesOf(warning) == group) text += Hanging("    " + RulesOf(warning) + ": ", warning.text, columns);
    }
  }
  return text;
}

std::string VerdictsText(const Ending& ending, std::size_t columns) {
  if (ending.verdicts.empty()) return "";
  std::size_t about = 0, grade = 0;
  for (const RunVerdict& verdict : ending.verdicts) {
    about = std::max(about, WidthOf(verdict.about));
    grade = std::max(grade, WidthOf(verdict.grade));
  }
  std::string text = "verdicts\n";
  for (const RunVerdict& verdict : ending.verdicts)
    text += Hanging("  " + PaddedTo(verdict.about, about) + "  " + PaddedTo(verdict.grade, grade) + "  ", verdict.why, columns);
  return text;
}

std::string ResultsText(const Ending& ending) {
  if (ending.results.empty()) return "";
  std::size_t label = 0;
  for (const RunFound& result : ending.results) label = std::max(label, WidthOf(result.label));
  std::string text = "results\n";
  // Never broken: a path is there to be copied.
  for (const RunFound& result : ending.results) text += "  " + PaddedTo(result.label, label) + "  " + result.path.string() + "\n";
  return text;
}

json ToJson(const RunWarning& warning) { return {{"steps", warning.steps}, {"poses", warning.poses}, {"text", warning.text}}; }

json ToJson(const RunVerdict& verdict) {
  return {{"about", verdict.about}, {"grade", verdict.grade}, {"why", verdict.why}, {"step", verdict.step}};
}

json ToJson(const RunFound& result) { return {{"label", result.label}, {"path", result.path.string()}, {"step", result.step}}; }

}  // namespace keypose::pipeline
