#include "studio/project/overview.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "pipeline/commands/keypose_commands.h"
#include "pipeline/disk/real_disk.h"
#include "pipeline/run/builder.h"
#include "pipeline/run/collect_ending.h"
#include "studio/project/failure_pictures.h"
#include "studio/project/left_out_photographs.h"
#include "studio/project/originals.h"
#include "studio/project/picks.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::Step;
using pipeline::StepPlan;

namespace {

bool HasPicks(Snapshot& snapshot, const std::string& pose) {
  try {
    return !ExistingPicks(snapshot, pose).empty();
  } catch (const Error&) {
    return false;  // PicksJson tells of it
  }
}

json PoseJson(Snapshot& snapshot, const std::string& pose) {
  const pipeline::PoseRule* rule = snapshot.file().FindPose(pose);
  const auto given = [&](const char* word, const std::string& otherwise) {
    const pipeline::Setting* path = rule ? rule->Given(word) : nullptr;
    return path ? path->text : otherwise;
  };
  json meshes = json::array();
  for (const MeshKind kind : {MeshKind::kMesh, MeshKind::kClean, MeshKind::kRefined,
                              MeshKind::kSurface, MeshKind::kCloud})
    if (snapshot.MeshPath(pose, kind)) meshes.push_back(NameOf(kind));
  const fs::path photos = snapshot.PhotoFolder(pose);
  return {{"name", pose},
          {"template", snapshot.IsTemplate(pose)},
          {"method", snapshot.IsFitted(pose) ? "fit" : "scan"},
          {"photos", given(pipeline::kPhotosWord, "photos/" + pose)},
          {"photographs", OriginalPhotographs(photos).size()},
          {"left_out", LeftOutNames(snapshot, pose).size()},
          {"masks", given("masks", "")},
          {"mesh", given("mesh", "")},
          {"has_landmarks", HasPicks(snapshot, pose)},
          {"meshes", meshes},
          {"has_texture", snapshot.TexturePath(pose).has_value()},
          {"has_confidence", snapshot.ConfidencePath(pose).has_value()},
          {"has_cameras", snapshot.CamerasPath(pose).has_value()},
          {"has_frames", snapshot.FramesPath(pose).has_value()}};
}

json NameAndFolder(const fs::path& folder) {
  return {{"name", folder.filename().string()},
          {"folder", folder.string()},
          {"kind", "poses"},
          {"poses", json::array()},
          {"template", ""},
          {"fps", 24},
          {"revision", ""},
          {"problem", ""},
          {"has_frames", false},
          {"has_report", false},
          {"has_shot", false},
          {"empty", false}};
}

std::string StateOf(const StepPlan& step) {
  const bool failed = step.last && step.last->failed;
  switch (step.state) {
    case StepPlan::State::kDone:
      return "done";
    case StepPlan::State::kReady:
      if (failed && step.last->failed_fingerprint == step.fingerprint) return "failed";
      return step.last ? "would_run" : "never";
    case StepPlan::State::kMissing:
      return "missing";
    default:
      return step.last ? "waits" : "never";
  }
}

void AddSet(const pipeline::StepOptionSettings& settings, const std::string& rule, bool pose,
            json* set) {
  const auto found = settings.find(rule);
  if (found == settings.end()) return;
  for (const auto& [option, setting] : found->second.options)
    (*set)[option] = {{"text", setting.text}, {"line", setting.where.line}, {"pose", pose}};
}

json StepJson(Snapshot& snapshot, int i) {
  const Step& step = snapshot.graph().steps[i];
  const StepPlan& planned = snapshot.plan()[i];
  json set = json::object();
  AddSet(snapshot.file().options, step.rule, false, &set);
  if (const auto* pose = snapshot.file().FindPose(step.pose))
    AddSet(pose->options, step.rule, true, &set);
  const bool waits = planned.state == StepPlan::State::kWaiting;
  return {{"id", step.id},
          {"step", step.rule},
          {"stage", step.info->stage},
          {"title", step.info->title},
          {"pose", step.pose},
          {"state", StateOf(planned)},
          {"seconds", planned.last ? planned.last->seconds : 0.0},
          {"reasons", planned.reasons},
          {"waits_for", waits ? snapshot.plan().WaitsFor(i) : std::vector<std::string>{}},
          {"error", planned.last && planned.last->failed ? planned.last->error : ""},
          {"pictures", FailurePicturesJson(snapshot, step)},
          {"exit_code", planned.last && planned.last->failed ? planned.last->exit_code : 0},
          {"options", step.options},
          {"set", set}};
}

/// The result's file with its label, if the pipeline shows it at a run's end.
std::string LabelOf(Snapshot& snapshot, const fs::path& path) {
  for (const Step& step : snapshot.graph().steps)
    for (const pipeline::ShownResult& shown : step.shown)
      if (shown.path == path) return shown.label;
  return "";
}

}  // namespace

json EmptyProjectJson(const fs::path& folder) {
  json project = NameAndFolder(folder);
  project["empty"] = true;
  return project;
}

json BrokenProjectJson(const fs::path& folder, const std::string& problem) {
  json project = NameAndFolder(folder);
  project["problem"] = problem;
  // A performance whose cameras are not calibrated yet has a page that does it.
  try {
    const auto file =
        pipeline::ParsePipelineFile(ReadFile(folder / "pipeline.yaml"), "pipeline.yaml");
    if (file.kind == pipeline::ProjectKind::kPerformance) project["kind"] = "performance";
  } catch (const Error&) {
    // the problem says it
  }
  project["revision"] = RevisionOf(folder / "pipeline.yaml");
  return project;
}

json ProjectJson(Snapshot& snapshot) {
  json project = NameAndFolder(snapshot.project());
  project["name"] = snapshot.graph().name;
  if (snapshot.graph().kind == pipeline::ProjectKind::kPerformance) project["kind"] = "performance";
  project["template"] = snapshot.graph().template_pose;
  project["fps"] = snapshot.file().fps;
  project["revision"] = RevisionOf(snapshot.project() / "pipeline.yaml");
  project["has_frames"] = snapshot.FramesPath("").has_value();
  project["has_shot"] = snapshot.file().shot.has_value();
  project["has_report"] = fs::exists(snapshot.project() / "out/report/index.html");
  // In the file's order, which people change; the graph begins with the template.
  for (const pipeline::PoseRule& rule : snapshot.file().poses)
    project["poses"].push_back(PoseJson(snapshot, rule.name));
  return project;
}

json NoStepsJson(bool running, const std::string& locked_by) {
  return {{"steps", json::array()},
          {"warnings", json::array()},
          {"earlier_warnings", json::array()},
          {"verdicts", json::array()},
          {"running", running},
          {"locked_by", locked_by}};
}

namespace {

json WarningsJson(const std::vector<pipeline::RunWarning>& warnings) {
  json list = json::array();
  for (const pipeline::RunWarning& warning : warnings)
    list.push_back({{"steps", warning.steps}, {"poses", warning.poses}, {"text", warning.text}});
  return list;
}

/// What steps said that will run again: of several photographs that are to be left out, one after
/// the other is.
std::vector<pipeline::RunWarning> EarlierWarnings(Snapshot& snapshot) {
  std::vector<pipeline::RunWarning> warnings;
  for (int i = 0; i < snapshot.plan().size(); ++i) {
    if (snapshot.plan()[i].state == pipeline::StepPlan::State::kDone) continue;
    const pipeline::Step& step = snapshot.graph().steps[static_cast<std::size_t>(i)];
    if (const auto artifact = snapshot.Result(step.rule, step.pose))
      pipeline::AddWarnings(*artifact, step, snapshot.opened_project().disk(), &warnings);
  }
  return warnings;
}

}  // namespace

json StepsJson(Snapshot& snapshot, bool running, const std::string& locked_by) {
  json all = NoStepsJson(running, locked_by);
  for (int i = 0; i < snapshot.plan().size(); ++i) all["steps"].push_back(StepJson(snapshot, i));
  const pipeline::Ending ending = pipeline::EndingOf(
      snapshot.plan(), snapshot.opened_project().disk(), snapshot.opened_project().out());
  all["warnings"] = WarningsJson(ending.warnings);
  all["earlier_warnings"] = WarningsJson(EarlierWarnings(snapshot));
  for (const auto& verdict : ending.verdicts)
    all["verdicts"].push_back({{"about", verdict.about},
                               {"grade", verdict.grade},
                               {"why", verdict.why},
                               {"step", verdict.step}});
  return all;
}

json StageJson(const std::string& describe) {
  const json value = json::parse(describe);
  json stage = {{"stage", value.at("stage")}, {"summary", value.value("summary", "")}};
  stage["options"] = json::array();
  for (const json& option : value.value("options", json::array())) {
    const std::string type = option.at("type");
    json one = {{"name", option.at("name")},
                {"type", type},
                {"unit", option.value("unit", "")},
                {"help", option.value("help", "")},
                {"common", option.value("common", false)}};
    const json& standard = option.at("default");
    one["default"] = standard.is_string() ? standard.get<std::string>() : standard.dump();
    for (const char* bound : {"min", "max"})
      if ((type == "int" || type == "double") && option.value(bound, json()).is_number())
        one[bound] = option[bound];
    if (option.contains("choices") && !option["choices"].empty())
      one["choices"] = option["choices"];
    stage["options"].push_back(one);
  }
  return stage;
}

std::string LogText(Snapshot& snapshot, const std::string& step) {
  constexpr std::size_t kMost = 1 << 20;
  const std::vector<int> found = snapshot.graph().Find(step);
  const std::string& id = snapshot.graph().steps[found.front()].id;
  // A step at work writes its log where the runner makes its results.
  fs::path log =
      snapshot.opened_project().state() / "tmp" / pipeline::FolderName(id) / "made" / "log.txt";
  if (!fs::is_regular_file(log)) log = pipeline::StepLog(snapshot.opened_project(), id);
  return log.empty() ? "" : WithoutOddBytes(snapshot.opened_project().disk().ReadEnd(log, kMost));
}

json ResultsJson(Snapshot& snapshot) {
  const fs::path out = snapshot.opened_project().out();
  json results = json::array();
  std::error_code ignored;
  for (const fs::path file : snapshot.opened_project().disk().FilesBelow(out)) {
    if (snapshot.opened_project().disk().LeadsOutside(out / file, out)) continue;
    results.push_back({{"path", file.generic_string()},
                       {"label", LabelOf(snapshot, file)},
                       {"bytes", fs::file_size(out / file, ignored)}});
  }
  return results;
}

}  // namespace keypose::studio
