#include "pipeline/run/collect_ending.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

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
    if (!name.empty() && std::find(names->begin(), names->end(), name) == names->end())
      names->push_back(name);
  };
  for (const json& text : *list) {
    if (!text.is_string() || text.get<std::string>().empty()) continue;
    auto same = std::find_if(warnings->begin(), warnings->end(),
                             [&](const RunWarning& warning) { return warning.text == text; });
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
    const RunVerdict verdict{TextAt(item, "about"), TextAt(item, "grade"), TextAt(item, "why"),
                             step.id};
    const auto same = [&](const RunVerdict& other) {
      return other.about == verdict.about && other.grade == verdict.grade &&
             other.why == verdict.why;
    };
    if (std::none_of(verdicts->begin(), verdicts->end(), same)) verdicts->push_back(verdict);
  }
}

void SortByPose(const std::vector<std::string>& poses, std::vector<RunVerdict>* verdicts) {
  const auto rank = [&](const RunVerdict& verdict) {
    return std::find(poses.begin(), poses.end(), verdict.about) - poses.begin();
  };
  std::stable_sort(verdicts->begin(), verdicts->end(),
                   [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
}

}  // namespace

void AddWarnings(const Artifact& artifact, const Step& step, const Disk& disk,
                 std::vector<RunWarning>* warnings) {
  AddWarnings(ReportOf(artifact, disk), step, warnings);
}

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

}  // namespace keypose::pipeline
