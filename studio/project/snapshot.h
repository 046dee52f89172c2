// A project as it is at one moment: its pipeline file, graph, plan, and where its results are.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "pipeline/graph/pipeline_edit.h"
#include "pipeline/run/opened_project.h"
#include "pipeline/run/plan.h"

namespace keypose::studio {

/// A mesh that a pose may have by now.
enum class MeshKind { kMesh, kClean, kRefined, kSurface, kCloud };
/// "mesh", "clean", "refined", "surface", "cloud"
std::optional<MeshKind> MeshKindNamed(const std::string& name);
std::string NameOf(MeshKind kind);

class Snapshot {
 public:
  /// @param project  the folder with pipeline.yaml
  /// @throws Error  as OpenedProject and Plan: what is wrong with pipeline.yaml or the project's
  /// files
  explicit Snapshot(const std::filesystem::path& project);

  const pipeline::Graph& graph() const { return opened_project_.graph(); }
  const pipeline::Plan& plan() const { return *plan_; }
  const pipeline::PipelineFile& file() const { return file_; }
  pipeline::OpenedProject& opened_project() { return opened_project_; }
  const std::filesystem::path& project() const { return opened_project_.project(); }

  bool HasPose(const std::string& pose) const;
  bool IsTemplate(const std::string& pose) const { return pose == graph().template_pose; }
  /// Whether the template is bent into the pose's few photographs, instead of a scan of it.
  bool IsFitted(const std::string& pose) const;
  /// The step of a rule on a pose; for rules of the animation or project, `pose` is empty.
  const pipeline::Step* FindStep(const std::string& rule, const std::string& pose) const;

  /// The newest result of a step, even if it is not up to date.
  std::optional<pipeline::Artifact> Result(const std::string& rule, const std::string& pose);
  /// A file or folder of that result; nothing when there is none.
  std::optional<std::filesystem::path> ResultPath(const std::string& rule, const std::string& pose,
                                                  const std::string& port);
  std::optional<std::filesystem::path> MeshPath(const std::string& pose, MeshKind kind);
  /// The pose's cameras, a COLMAP model.
  std::optional<std::filesystem::path> CamerasPath(const std::string& pose);
  /// The pose's texture as export would take it.
  std::optional<std::filesystem::path> TexturePath(const std::string& pose);
  /// How well photographs show each texel of it.
  std::optional<std::filesystem::path> ConfidencePath(const std::string& pose);
  /// The folder of moving meshes: of the animation for "", else of that shot of a performance, as
  /// its export takes them.
  std::optional<std::filesystem::path> FramesPath(const std::string& shot);
  /// The mesh on which a pose's landmarks are picked; a pose from few photographs has none.
  std::optional<std::filesystem::path> PickedMesh(const std::string& pose);
  /// The folder of a pose's photographs.
  std::filesystem::path PhotoFolder(const std::string& pose) const;

 private:
  pipeline::OpenedProject opened_project_;
  pipeline::PipelineFile file_;
  std::unique_ptr<pipeline::Plan> plan_;
};

using pipeline::RevisionOf;

}  // namespace keypose::studio
