#include "studio/project/changes.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "core/io/pictures/photograph_files.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/commands/new_project.h"
#include "pipeline/text/text.h"

namespace keypose::studio {

namespace fs = std::filesystem;

namespace {

std::string FileText(Snapshot& snapshot) { return ReadFile(snapshot.project() / "pipeline.yaml"); }

void CheckOption(Snapshot& snapshot, const OptionChange& change) {
  if (!change.pose.empty() && !snapshot.HasPose(change.pose))
    throw UsageError(fmt::format("there is no pose '{}'", change.pose));
  const pipeline::Step* step = snapshot.FindStep(change.step, "");
  if (step == nullptr) throw UsageError(fmt::format("there is no step '{}'", change.step));
  const pipeline::OptionInfo& option = pipeline::OptionOf(*step->info, change.option);
  if (!change.to_default) pipeline::CanonicalOption(option, change.value);
}

void RequirePoseName(const std::string& name, const char* of = "pose") {
  if (!pipeline::IsName(name))
    throw UsageError(
        fmt::format("a {}'s name may have {}; '{}' has not", of, pipeline::kNameRule, name));
}

}  // namespace

nlohmann::json JsonOfFile(const fs::path& file) {
  const std::string text = ReadFile(file), name = file.filename().string();
  RequireShallowJson(text, name);
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& fault) {
    throw InputError(name + " is not JSON: " + JsonFault(fault));
  }
}

std::string WithPoseSetting(const Snapshot& snapshot, const std::string& text,
                            const std::string& pose, const YamlPath& below,
                            const std::string& value) {
  return pipeline::WithPoseSetting(snapshot.file(), text, pose, below, value);
}

void RequirePhotograph(Snapshot& snapshot, const std::string& pose, const std::string& name) {
  if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
  if (!IsOneName(name) || !IsValidUtf8(name) || IsLitterName(name))
    throw UsageError(fmt::format("'{}' cannot be the name of a photograph", name));
}

std::string SetOption(Snapshot& snapshot, const OptionChange& change, const std::string& revision) {
  CheckOption(snapshot, change);
  const std::string text = FileText(snapshot);
  const YamlPath below = {"options", change.step, change.option};
  const std::string edited = Edited([&] {
    if (change.to_default) {
      YamlPath path = change.pose.empty() ? YamlPath{} : YamlPath{"poses", change.pose};
      path.insert(path.end(), below.begin(), below.end());
      return WithoutValue(text, path);
    }
    const std::string value = YamlScalar(change.value);
    if (change.pose.empty()) return WithValue(text, below, value);
    return WithPoseSetting(snapshot, text, change.pose, below, value);
  });
  return WritePipelineFile(snapshot.project(), edited, revision);
}

void CreateProject(const fs::path& folder, const std::vector<std::string>& poses,
                   const std::string& template_pose, const std::vector<std::string>& few) {
  if (poses.empty()) throw UsageError("name at least one pose");
  std::vector<std::string> names;
  for (const std::string& name : poses) {
    RequirePoseName(name);
    names.push_back(pipeline::Composed(name));
    if (std::count(names.begin(), names.end(), names.back()) > 1)
      throw UsageError(fmt::format("two poses are called '{}'", name));
  }
  const std::string chosen = pipeline::Composed(template_pose);
  if (std::find(names.begin(), names.end(), chosen) == names.end())
    throw UsageError(fmt::format("the template '{}' is none of the poses", template_pose));
  std::set<std::string> fitted;
  for (const std::string& name : few) {
    fitted.insert(pipeline::Composed(name));
    if (std::find(names.begin(), names.end(), pipeline::Composed(name)) == names.end())
      throw UsageError(fmt::format("'{}' is to be fitted, but is none of the poses", name));
  }
  if (fitted.contains(chosen))
    throw UsageError(fmt::format(
        "'{}' is the template, which other poses are fitted with: it needs a scan", chosen));
  if (fs::exists(folder / "pipeline.yaml"))
    throw UsageError("there is a project in this folder already");
  for (const std::string& name : names) fs::create_directories(folder / "photos" / name);
  WriteFileAtomically(folder / "pipeline.yaml",
                      pipeline::NewPipelineText(folder, names, chosen, fitted));
}

void CreatePerformance(const fs::path& folder, const FilmedProject& project) {
  if (project.shots.empty()) throw UsageError("name at least one shot");
  if (fs::exists(folder / "pipeline.yaml"))
    throw UsageError("there is a project in this folder already");
  pipeline::NewPerformance performance;
  performance.video3d = project.video3d;
  performance.surface = project.surface;
  std::set<std::string> names;
  for (const std::string& name : project.shots) {
    RequirePoseName(name, "shot");
    const std::string shot = pipeline::Composed(name);
    if (!names.insert(shot).second)
      throw UsageError(fmt::format("two shots are called '{}'", name));
    performance.shots.emplace_back(shot, "shots/" + shot);
  }
  for (const std::string& name : names) fs::create_directories(folder / "shots" / name);
  WriteFileAtomically(folder / "pipeline.yaml", pipeline::NewPerformanceText(folder, performance));
}

void AddShot(const fs::path& project, const std::string& shot) {
  RequirePoseName(shot, "shot");
  const std::string name = pipeline::Composed(shot);
  const fs::path plan = project / "pipeline.yaml";
  const std::string text = ReadFile(plan), revision = RevisionOf(plan);
  const auto file = pipeline::ParsePipelineFile(text, "pipeline.yaml");
  if (file.kind != pipeline::ProjectKind::kPerformance)
    throw UsageError("only a performance has shots");
  if (file.FindPose(name)) throw UsageError(fmt::format("there is a shot '{}' already", name));
  const std::string edited = Edited([&] {
    return WithValue(text, {"shots", name, "video"}, YamlScalar("shots/" + name));
  });
  fs::create_directories(project / "shots" / name);
  WritePipelineFile(project, edited, revision);
}

}  // namespace keypose::studio
