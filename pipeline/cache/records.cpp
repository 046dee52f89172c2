#include "pipeline/cache/records.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/values/size_of.h"
#include "pipeline/cache/run_history.h"

namespace keypose::pipeline {

using nlohmann::json;

Records::Records(Disk& disk, std::filesystem::path state_folder)
    : disk_(disk), state_folder_(std::move(state_folder)) {}

std::filesystem::path Records::StepFile(const std::string& step_id) const {
  return state_folder_ / "steps" / (step_id + ".json");
}

std::optional<StepRecord> Records::Last(const std::string& step_id) const {
  if (!disk_.Stat(StepFile(step_id))) return std::nullopt;
  try {
    const json value = json::parse(disk_.Read(StepFile(step_id)));
    StepRecord record;
    record.fingerprint = value.at("fingerprint").get<std::string>();
    record.recipe = RecipeFromJson(value.at("recipe"));
    record.seconds = value.at("seconds").get<double>();
    record.peak_bytes = value.at("peak_bytes").get<std::int64_t>();
    record.when = value.at("when").get<double>();
    record.reasons = value.at("reasons").get<std::vector<std::string>>();
    record.found = value.value("found", false);
    record.failed = value.at("failed").get<bool>();
    record.exit_code = value.at("exit_code").get<int>();
    record.failed_fingerprint = value.at("failed_fingerprint").get<std::string>();
    record.error = value.at("error").get<std::string>();
    if (!record.fingerprint.empty() && !IsFingerprint(record.fingerprint)) return std::nullopt;
    return record;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

void Records::SetLast(const std::string& step_id, const StepRecord& record) {
  const json value = {{"schema", 1},
                      {"fingerprint", record.fingerprint},
                      {"recipe", ToJson(record.recipe)},
                      {"seconds", record.seconds},
                      {"peak_bytes", record.peak_bytes},
                      {"when", record.when},
                      {"reasons", record.reasons},
                      {"found", record.found},
                      {"failed", record.failed},
                      {"exit_code", record.exit_code},
                      {"failed_fingerprint", record.failed_fingerprint},
                      {"error", record.error}};
  disk_.Write(StepFile(step_id), value.dump(1, ' ', false, json::error_handler_t::replace));
}

void Records::Save(const RunRecord& run) {
  json steps = json::array();
  for (const RunStep& step : run.steps) {
    steps.push_back({{"id", step.id},
                     {"status", step.status},
                     {"fingerprint", step.fingerprint},
                     {"seconds", step.seconds},
                     {"peak_bytes", step.peak_bytes},
                     {"reasons", step.reasons}});
  }
  const auto list = [](const auto& items) {
    json all = json::array();
    for (const auto& item : items) all.push_back(ToJson(item));
    return all;
  };
  const json value = {{"schema", 1},
                      {"begin", TimeText(run.begin)},
                      {"seconds", run.end - run.begin},
                      {"command", run.command},
                      {"host", run.host},
                      {"exit_code", run.exit_code},
                      {"steps", steps},
                      {"warnings", list(run.ending.warnings)},
                      {"verdicts", list(run.ending.verdicts)},
                      {"results", list(run.ending.results)}};
  disk_.Write(state_folder_ / "runs" / (run.name + ".json"),
              value.dump(1, ' ', false, json::error_handler_t::replace));
}

std::vector<std::string> Records::Steps() const {
  constexpr std::string_view kExtension = ".json";
  std::vector<std::string> steps;
  for (const std::string& name : disk_.FilesBelow(state_folder_ / "steps"))
    if (name.ends_with(kExtension))
      steps.push_back(name.substr(0, name.size() - kExtension.size()));
  return steps;
}

void Records::ForgetStepsOutside(const std::set<std::string>& steps) {
  for (const std::string& step : Steps())
    if (!steps.contains(step)) disk_.Remove(StepFile(step));
}

std::set<std::string> Records::Mentioned(int runs, const std::set<std::string>& steps) const {
  std::set<std::string> mentioned;
  std::vector<std::string> names = disk_.Children(state_folder_ / "runs");
  std::reverse(names.begin(), names.end());
  if (SizeOf(names) > runs) names.resize(static_cast<std::size_t>(runs));
  for (const std::string& name : names) {
    const json value = json::parse(disk_.Read(state_folder_ / "runs" / name), nullptr, false);
    if (!value.is_object()) continue;
    const auto made = value.find("steps");
    if (made == value.end() || !made->is_array()) continue;
    for (const json& step : *made)
      if (step.is_object() && step.contains("fingerprint") && step["fingerprint"].is_string())
        mentioned.insert(step["fingerprint"]);
  }
  for (const std::string& step : steps)
    if (const auto record = Last(step)) mentioned.insert(record->fingerprint);
  return mentioned;
}

int Records::DropOldRuns(int runs) {
  const std::vector<std::string> names = disk_.Children(state_folder_ / "runs");
  const int drop = std::max(0, SizeOf(names) - runs);
  for (int i = 0; i < drop; ++i) disk_.Remove(state_folder_ / "runs" / names[i]);
  return drop;
}

std::string TimeText(double seconds_since_1970) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC",
                     fmt::gmtime(static_cast<std::time_t>(seconds_since_1970)));
}

}  // namespace keypose::pipeline
