#include "studio/project/pose_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/io/text/pose_yaml.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/text/text.h"
#include "studio/project/changes.h"
#include "studio/project/moves.h"
#include "studio/project/reviews.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// pipeline.yaml as it is, for one change.
struct Whole {
  explicit Whole(const Snapshot& snapshot)
      : project(snapshot.project()),
        revision(RevisionOf(project / "pipeline.yaml")),
        text(ReadFile(project / "pipeline.yaml")) {
    if (snapshot.graph().kind == pipeline::ProjectKind::kPerformance)
      throw UsageError("a performance has shots, and no poses");
  }
  void Write(const std::string& edited) const {
    if (edited != text) WriteCheckedPipeline(project, text, edited, revision);
  }
  const fs::path project;
  const std::string revision, text;
};

void RequireNamed(const Snapshot& snapshot, const std::string& pose) {
  if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
}

/// Folders of two poses must differ on disks that take a and A for one, too.
void RequireFree(const Snapshot& snapshot, const std::string& name, const std::string& besides) {
  if (!pipeline::IsName(name))
    throw UsageError(
        fmt::format("a pose's name may have {}; '{}' has not", pipeline::kNameRule, name));
  for (const std::string& pose : snapshot.graph().poses)
    if (pose != besides && LowerCase(pose) == LowerCase(name))
      throw UsageError(fmt::format("there is a pose '{}' already", pose));
}

/// The path that a pose names by a word, relative to the project and without . and ..
fs::path Named(const pipeline::PoseRule& rule, const char* word) {
  const pipeline::Setting* given = rule.Given(word);
  return given ? fs::path(given->text).lexically_normal() : fs::path();
}

/// Where the pose's own things lie, by the words under which pipeline.yaml names them; "": by their
/// default alone.
std::vector<std::pair<std::string, fs::path>> PlacesOf(const Snapshot& snapshot,
                                                       const std::string& pose) {
  const pipeline::PoseRule& rule = *snapshot.file().FindPose(pose);
  std::vector<std::pair<std::string, fs::path>> places;
  const auto add = [&](const char* word, const fs::path& usual, bool by_default) {
    fs::path named = Named(rule, word);
    if (!named.has_filename()) named = named.parent_path();
    if (named == usual)
      places.emplace_back(word, usual);
    else if (named.empty() && by_default)
      places.emplace_back("", usual);
  };
  add("photos", fs::path("photos") / pose, rule.Given("mesh") == nullptr);
  add("masks", fs::path("masks") / pose, false);
  for (const char* ending : {".json", ".pp"})
    add("landmarks", fs::path("landmarks") / (pose + ending), true);
  add("mending", fs::path("mending") / (pose + ".json"), true);
  std::erase_if(places, [&](const auto& place) {
    std::error_code error;
    return !fs::exists(snapshot.project() / place.second, error);
  });
  return places;
}

bool IsUsedByAnother(const Snapshot& snapshot, const std::string& pose, const fs::path& path) {
  for (const pipeline::PoseRule& rule : snapshot.file().poses)
    if (rule.name != pose)
      for (const pipeline::GivenSource& given : rule.given)
        if (IsWithin(fs::path(given.path.text).lexically_normal(), path)) return true;
  return false;
}

}  // namespace

void WriteCheckedPipeline(const fs::path& project, const std::string& before,
                          const std::string& text, const std::string& revision) {
  const std::string now = WritePipelineFile(project, text, revision);
  try {
    Snapshot opened(project);
  } catch (const Error&) {
    WritePipelineFile(project, before, now);
    throw;
  }
}

std::vector<fs::path> FilesOfPose(Snapshot& snapshot, const std::string& pose) {
  std::vector<fs::path> files;
  for (const auto& [word, path] : PlacesOf(snapshot, pose))
    if (!IsUsedByAnother(snapshot, pose, path)) files.push_back(path);
  return files;
}

void AddPose(Snapshot& snapshot, const std::string& pose, bool few) {
  const Whole whole(snapshot);
  const std::string name = pipeline::Composed(pose);
  RequireFree(snapshot, name, "");
  fs::create_directories(whole.project / "photos" / name);
  whole.Write(Edited([&] { return WithPose(whole.text, name, few); }));
}

void RenamePose(Snapshot& snapshot, const std::string& pose, const std::string& to) {
  const Whole whole(snapshot);
  const std::string name = pipeline::Composed(to);
  RequireNamed(snapshot, pose);
  if (name == pose) return;
  RequireFree(snapshot, name, pose);
  std::string edited = Edited([&] { return WithPoseRenamed(whole.text, pose, name); });
  Moves moves(whole.project);
  for (const auto& [word, path] : PlacesOf(snapshot, pose)) {
    if (IsUsedByAnother(snapshot, pose, path)) continue;
    const bool folder = fs::is_directory(whole.project / path);
    const fs::path renamed =
        path.parent_path() / (name + (folder ? "" : path.extension().string()));
    moves.Do(path, renamed);
    if (word.empty()) continue;
    edited = Edited([&] {
      const bool short_form = word == "photos" && PoseValue(edited, name)[0] != '{';
      const YamlPath at = short_form ? YamlPath{"poses", name} : YamlPath{"poses", name, word};
      return WithValue(edited, at, YamlScalar(renamed.generic_string()));
    });
  }
  whole.Write(edited);
  moves.Keep();
  RenameReviewed(whole.project, pose, name);
}

void OrderPoses(Snapshot& snapshot, const std::vector<std::string>& order) {
  const Whole whole(snapshot);
  // Without `template`, the first pose is it: it stays so.
  const std::string chosen = snapshot.graph().template_pose;
  whole.Write(Edited([&] {
    const std::string sorted = WithPoseOrder(whole.text, order);
    return TemplateIn(sorted) == chosen ? sorted
                                        : WithValue(sorted, {"template"}, YamlScalar(chosen));
  }));
}

void ChooseTemplate(Snapshot& snapshot, const std::string& pose) {
  const Whole whole(snapshot);
  RequireNamed(snapshot, pose);
  if (snapshot.IsFitted(pose))
    throw UsageError(
        fmt::format("'{}' has few photographs, which the template is bent into: the template needs "
                    "photographs all round",
                    pose));
  whole.Write(Edited([&] { return WithValue(whole.text, {"template"}, YamlScalar(pose)); }));
}

void ChooseMethod(Snapshot& snapshot, const std::string& pose, bool few) {
  const Whole whole(snapshot);
  RequireNamed(snapshot, pose);
  if (few && snapshot.IsTemplate(pose))
    throw UsageError(
        fmt::format("'{}' is the template, which other poses are bent from: it is scanned", pose));
  whole.Write(Edited([&] { return WithMethod(whole.text, pose, few ? "fit" : ""); }));
}

std::string WithPoseBack(const std::string& text, const std::string& pose, const json& what) {
  const auto poses = PosesIn(text);
  if (std::find(poses.begin(), poses.end(), pose) != poses.end())
    throw UsageError(fmt::format("there is a pose '{}' by now; rename that first", pose));
  if (!pipeline::IsName(pose)) throw UsageError("the bin's entry names no pose");
  if (what.contains("pipeline"))
    return keypose::WithPoseBack(text, pose, what.at("pipeline").get<std::string>());
  // of an entry that an earlier version made
  const bool lists = what.value("on_timeline", false) && TimelineOnlyListsPoses(text);
  const std::string value = what.value("yaml", "");
  const std::string with = lists ? WithPose(text, pose, false) : text;
  return WithValue(with, {"poses", pose}, value.empty() ? "photos/" + pose : value);
}

}  // namespace keypose::studio
