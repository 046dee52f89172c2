#include "report/evidence/run_record.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/values/errors.h"

namespace keypose::report {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

fs::path Absolute(const fs::path& base, const std::string& path) {
  return fs::path(path).is_absolute() ? fs::path(path) : base / path;
}

std::string TextOf(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

void TakeMeasurements(const json& measurements, StepRecord& step) {
  for (const auto& [name, value] : measurements.items()) {
    if (value.is_boolean()) {
      step.flags[name] = value;
      step.numbers[name] = value.get<bool>() ? 1 : 0;
    }
    if (value.is_number()) step.numbers[name] = value;
    if (value.is_string()) step.texts[name] = value;
    if (value.is_structured()) step.lists[name] = value.dump();
  }
}

void ReadStageReport(const fs::path& path, const FileReader& read, StepRecord& step) {
  try {
    const json report = json::parse(read(path));
    step.version = TextOf(report, "version");
    if (step.stage.empty()) step.stage = TextOf(report, "stage");
    if (step.seconds == 0) step.seconds = report.value("seconds", 0.0);
    if (step.peak_bytes == 0) step.peak_bytes = report.value("peak_bytes", std::int64_t{0});
    const json options = report.value("options", json::object());
    for (const auto& [name, value] : options.items()) step.options[name] = value.dump();
    step.warnings = report.value("warnings", std::vector<std::string>{});
    TakeMeasurements(report.value("measurements", json::object()), step);
  } catch (const std::exception& error) {
    step.trouble = "its report cannot be read: " + std::string(error.what());
  }
}

std::optional<double> Bound(const json& described, const char* which) {
  const json good = described.value("good", json::object());
  return good.contains(which) ? std::optional(good[which].get<double>()) : std::nullopt;
}

std::vector<Described> ReadDescribed(const json& entry) {
  std::vector<Described> all;
  for (const json& one : entry.value("described", json::array()))
    all.push_back({TextOf(one, "key"), TextOf(one, "label"), TextOf(one, "unit"), Bound(one, "min"),
                   Bound(one, "max")});
  return all;
}

StepRecord ReadStep(const json& entry, const fs::path& base, const FileReader& read) {
  StepRecord step;
  step.id = TextOf(entry, "id");
  step.step = TextOf(entry, "step");
  step.stage = TextOf(entry, "stage");
  if (step.stage.empty()) step.stage = step.step;
  step.title = TextOf(entry, "title");
  if (step.title.empty()) step.title = step.stage;
  step.described = ReadDescribed(entry);
  step.pose = TextOf(entry, "pose");
  step.source_pose = TextOf(entry, "source_pose");
  if (entry.contains("status")) step.status = TextOf(entry, "status");
  step.fingerprint = TextOf(entry, "fingerprint");
  step.seconds = entry.value("seconds", 0.0);
  step.peak_bytes = entry.value("peak_bytes", std::int64_t{0});
  step.cached = entry.value("cached", false);
  const json outputs = entry.value("outputs", json::object()),
             inputs = entry.value("inputs", json::object());
  for (const auto& [port, path] : outputs.items())
    step.outputs[port] = Absolute(base, path.get<std::string>());
  for (const auto& [port, paths] : inputs.items())
    for (const auto& path : paths)
      step.inputs[port].push_back(Absolute(base, path.get<std::string>()));
  const std::string report = TextOf(entry, "report");
  if (!report.empty()) ReadStageReport(Absolute(base, report), read, step);
  return step;
}

}  // namespace

std::optional<double> StepRecord::Number(const std::string& name) const {
  const auto found = numbers.find(name);
  return found == numbers.end() ? std::nullopt : std::optional(found->second);
}

fs::path StepRecord::Output(const std::string& port) const {
  const auto found = outputs.find(port);
  return found != outputs.end() ? found->second : fs::path();
}

fs::path StepRecord::Input(const std::string& port) const {
  const auto found = inputs.find(port);
  return found != inputs.end() && !found->second.empty() ? found->second[0] : fs::path();
}

const StepRecord* RunRecord::Find(const std::string& stage, const std::string& pose) const {
  for (const StepRecord& step : steps)
    if (step.stage == stage && (pose.empty() || step.pose == pose)) return &step;
  return nullptr;
}

fs::path RunRecord::TextureOf(const std::string& pose) const {
  const StepRecord *complete = Find("complete", pose), *bake = Find("bake", pose);
  if (complete && !complete->Output("completed").empty()) return complete->Output("completed");
  return bake ? bake->Output("texture") : fs::path();
}

std::vector<const StepRecord*> RunRecord::All(const std::string& stage) const {
  std::vector<const StepRecord*> found;
  for (const StepRecord& step : steps)
    if (step.stage == stage) found.push_back(&step);
  return found;
}

const StepRecord* RunRecord::ExportOf(const fs::path& frames) const {
  for (const StepRecord* step : All("export"))
    if (step->Input("frames") == frames) return step;
  return nullptr;
}

double RunRecord::ExportedRate(const fs::path& frames) const {
  const StepRecord* step = ExportOf(frames);
  if (!step) return 0;
  const auto option = step->options.find("fps");
  if (option == step->options.end()) return 0;
  const json fps = json::parse(option->second, nullptr, false);
  return fps.is_number() ? std::max(0.0, fps.get<double>()) : 0;
}

RunRecord ParseRun(const std::string& text, const fs::path& folder, const FileReader& read) {
  try {
    const json record = json::parse(text);
    if (record.value("schema", 0) != 1)
      throw InputError("report: the schema of run.json is not 1; run the pipeline again");
    RunRecord run;
    const json project = record.at("project");
    run.project = TextOf(project, "name");
    run.template_pose = TextOf(project, "template");
    run.performance = TextOf(project, "kind") == "performance";
    run.poses = project.at("poses").get<std::vector<std::string>>();
    if (record.contains("timeline") && !record["timeline"].is_null())
      run.timeline = record["timeline"].dump();
    for (const json& entry : record.at("steps")) run.steps.push_back(ReadStep(entry, folder, read));
    return run;
  } catch (const json::exception& error) {
    throw InputError("report: run.json is not the record of a run: " + std::string(error.what()) +
                     "; pass the file that the runner wrote");
  }
}

}  // namespace keypose::report
