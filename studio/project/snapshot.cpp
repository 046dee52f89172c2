#include "studio/project/snapshot.h"

#include <algorithm>

#include "core/io/text/files.h"
#include "core/values/file_names.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/graph/sources.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using pipeline::Step;

namespace {

struct KindRow {
  MeshKind kind;
  const char* name;
  const char* rule;
  const char* port;
};
constexpr KindRow kKinds[] = {
    {MeshKind::kMesh, "mesh", "register", "registered"},
    {MeshKind::kClean, "clean", "cleanup", "clean"},
    {MeshKind::kRefined, "refined", "refine", "refined"},
    {MeshKind::kSurface, "surface", "mesh", "surface"},
    {MeshKind::kCloud, "cloud", "dense", "cloud"},
};

const KindRow& RowOf(MeshKind kind) {
  return *std::find_if(std::begin(kKinds), std::end(kKinds),
                       [&](const KindRow& row) { return row.kind == kind; });
}

/// A file of the project that pipeline.yaml names for a pose by a word; nothing: none is there.
std::optional<fs::path> GivenFile(const Snapshot& snapshot, const std::string& pose,
                                  const char* word) {
  const pipeline::PoseRule* rule = snapshot.file().FindPose(pose);
  const pipeline::Setting* given = rule ? rule->Given(word) : nullptr;
  if (!given) return std::nullopt;
  const fs::path& project = snapshot.project();
  const std::string written = pipeline::WithHome(given->text);
  const fs::path path = project / pipeline::OnDisk(pipeline::RealDisk(), project, written);
  std::error_code error;
  const bool usable = fs::is_regular_file(path, error) &&
                      IsWithin(fs::weakly_canonical(path), fs::canonical(project));
  return usable ? std::optional(path) : std::nullopt;
}

}  // namespace

std::optional<MeshKind> MeshKindNamed(const std::string& name) {
  for (const KindRow& row : kKinds)
    if (name == row.name) return row.kind;
  return std::nullopt;
}

std::string NameOf(MeshKind kind) { return RowOf(kind).name; }

Snapshot::Snapshot(const fs::path& project)
    : opened_project_(project, {}),
      file_(pipeline::ParsePipelineFile(ReadFile(project / "pipeline.yaml"), "pipeline.yaml")),
      plan_(std::make_unique<pipeline::Plan>(opened_project_.graph(), opened_project_.workshop(),
                                             pipeline::Selection{})) {
  opened_project_.workshop().hasher.Save();
}

bool Snapshot::HasPose(const std::string& pose) const {
  const auto& poses = graph().poses;
  return std::find(poses.begin(), poses.end(), pose) != poses.end();
}

bool Snapshot::IsFitted(const std::string& pose) const {
  const pipeline::PoseRule* rule = file_.FindPose(pose);
  return rule && rule->FoundBy() == pipeline::Method::kFit;
}

const Step* Snapshot::FindStep(const std::string& rule, const std::string& pose) const {
  for (const Step& step : graph().steps)
    if (step.rule == rule && (pose.empty() || step.pose == pose)) return &step;
  return nullptr;
}

std::optional<pipeline::Artifact> Snapshot::Result(const std::string& rule,
                                                   const std::string& pose) {
  const Step* step = FindStep(rule, pose);
  if (step == nullptr) return std::nullopt;
  const auto& planned = plan()[static_cast<int>(step - graph().steps.data())];
  if (planned.artifact) return planned.artifact;
  if (!planned.last || planned.last->fingerprint.empty()) return std::nullopt;
  return opened_project_.store().Find(planned.last->fingerprint);
}

std::optional<fs::path> Snapshot::ResultPath(const std::string& rule, const std::string& pose,
                                             const std::string& port) {
  const auto result = Result(rule, pose);
  if (!result || !result->outputs.contains(port)) return std::nullopt;
  return result->Path(port);
}

std::optional<fs::path> Snapshot::MeshPath(const std::string& pose, MeshKind kind) {
  // Meshes of the same faces are animated as they are: nothing is made of them.
  if (kind == MeshKind::kMesh && !FindStep("unwrap", graph().template_pose))
    return GivenFile(*this, pose, "mesh");
  if (kind == MeshKind::kMesh && IsTemplate(pose)) return ResultPath("unwrap", pose, "unwrapped");
  if (kind == MeshKind::kMesh && IsFitted(pose)) return ResultPath("fit", pose, "fitted");
  if (kind == MeshKind::kClean)
    if (auto mended = ResultPath("mend", pose, "mended")) return mended;
  return ResultPath(RowOf(kind).rule, pose, RowOf(kind).port);
}

std::optional<fs::path> Snapshot::CamerasPath(const std::string& pose) {
  return ResultPath(IsFitted(pose) ? "fit" : "sfm", pose, "model");
}

std::optional<fs::path> Snapshot::TexturePath(const std::string& pose) {
  if (auto completed = ResultPath("complete", pose, "completed")) return completed;
  if (FindStep("bake", pose)) return ResultPath("bake", pose, "texture");
  return GivenFile(*this, pose, "texture");
}

std::optional<fs::path> Snapshot::ConfidencePath(const std::string& pose) {
  return ResultPath("bake", pose, "confidence");
}

std::optional<fs::path> Snapshot::FramesPath(const std::string& shot) {
  if (shot.empty()) return ResultPath("interpolate", "", "frames");
  if (auto bent = ResultPath("follow", shot, "followed")) return bent;
  if (auto scan = ResultPath("transfer", shot, "frames")) return scan;
  return ResultPath("track", shot, "frames");
}

std::optional<fs::path> Snapshot::PickedMesh(const std::string& pose) {
  return MeshPath(pose, IsTemplate(pose) ? MeshKind::kMesh : MeshKind::kClean);
}

fs::path Snapshot::PhotoFolder(const std::string& pose) const {
  const pipeline::PoseRule* rule = file_.FindPose(pose);
  const fs::path written = rule ? pipeline::PhotographsOf(*rule) : "photos/" + pose;
  return project() / pipeline::OnDisk(pipeline::RealDisk(), project(), written);
}

}  // namespace keypose::studio
