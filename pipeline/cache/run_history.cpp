#include "pipeline/cache/run_history.h"

#include <nlohmann/json.hpp>

#include "core/io/text/files.h"

namespace keypose::pipeline {

using nlohmann::json;

bool IsFingerprint(const std::string& text) {
  return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

namespace {

std::string TextIn(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

PastRun PastRunOf(const std::string& name, const json& value) {
  PastRun run{name, TextIn(value, "begin"), {}};
  const auto steps = value.find("steps");
  if (steps == value.end() || !steps->is_array()) return run;
  for (const json& step : *steps) {
    if (!step.is_object()) continue;
    const std::string status = TextIn(step, "status"), fingerprint = TextIn(step, "fingerprint");
    if ((status == "made" || status == "cached") && IsFingerprint(fingerprint))
      run.steps.push_back({TextIn(step, "id"), fingerprint});
  }
  return run;
}

}  // namespace

std::vector<PastRun> PastRuns(const Disk& disk, const std::filesystem::path& state_folder) {
  const std::filesystem::path folder = state_folder / "runs";
  std::vector<PastRun> runs;
  // Their names begin with the time.
  for (const std::string& name : disk.Children(folder)) {
    const auto stat = disk.Stat(folder / name);
    if (!name.ends_with(".json") || !stat || stat->folder) continue;
    const std::string text = disk.Read(folder / name);
    const json value = IsShallowJson(text) ? json::parse(text, nullptr, false) : json();
    if (value.is_object()) runs.push_back(PastRunOf(name.substr(0, name.size() - 5), value));
  }
  return runs;
}

}  // namespace keypose::pipeline
