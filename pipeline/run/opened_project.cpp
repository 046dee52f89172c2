#include "pipeline/run/opened_project.h"

#include <fmt/format.h>

#include <chrono>

#include "core/values/errors.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/graph/pipeline_overlay.h"

namespace keypose::pipeline {

namespace fs = std::filesystem;

double RealClock::Now() const {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

fs::path ProgramFolder() { return fs::read_symlink("/proc/self/exe").parent_path(); }

fs::path DefaultPipelineFile(ProjectKind kind) {
  const fs::path name = kind == ProjectKind::kPerformance ? "performance.yaml" : "pipeline.yaml";
  const fs::path file = (ProgramFolder() / "../share/keypose" / name).lexically_normal();
  if (!fs::exists(file))
    throw DiskError(
        fmt::format("the default pipeline {} is missing; install keypose again", file.string()));
  return file;
}

namespace {

/// A project from elsewhere must not make keypose write caches and locks, or delete temporary
/// files, outside of it.
void RequireOwnState(const fs::path& project) {
  const fs::path state = project / ".keypose";
  for (const char* name : {"", "cache", "failed", "runs", "steps", "tmp", "writing"}) {
    const fs::path folder = *name ? state / name : state;
    if (!RealDisk().LeadsOutside(folder, project)) continue;
    throw DiskError(
        fmt::format("{} is a link that leads to {}, outside of the project; remove the link, or "
                    "move the whole project there",
                    folder.string(), fs::weakly_canonical(folder).string()));
  }
}

/// What the programs say of themselves, for all projects of this user.
fs::path SharedStages() {
  const fs::path folder = UserCacheFolder();
  return folder.empty() ? folder : folder / "stages.json";
}

}  // namespace

fs::path FindProject(const std::string& folder) {
  const fs::path start =
      fs::absolute(folder.empty() ? fs::path(".") : fs::path(folder)).lexically_normal();
  for (fs::path candidate = start;; candidate = candidate.parent_path()) {
    // "a/b/" ends with an empty file name, and the loop would check the same folder twice.
    if (!candidate.has_filename() && candidate != candidate.root_path()) continue;
    if (fs::is_regular_file(candidate / "pipeline.yaml")) {
      RequireOwnState(candidate);
      return candidate;
    }
    if (fs::exists(candidate / "pipeline.yaml"))
      throw DiskError((candidate / "pipeline.yaml").string() +
                      " is a folder, a pipe or a device, but a file is needed");
    if (!folder.empty() || candidate == candidate.root_path()) break;
  }
  throw UsageError(
      fmt::format("{} is not a keypose project: it has no pipeline.yaml; make one with `keypose "
                  "init DIR --pose NAME=PHOTO_DIR`, or name "
                  "one with -C DIR",
                  start.string()));
}

OpenedProject::OpenedProject(const fs::path& project, const std::vector<Override>& overrides,
                             bool catch_signals)
    : project_(project),
      disk_(project / ".keypose" / "writing"),
      processes_(catch_signals),
      catalog_(disk_, processes_, project / ".keypose" / "stages.json", SharedStages()),
      hasher_(disk_, project / ".keypose" / "hashes.json", project),
      store_(disk_, project / ".keypose"),
      records_(disk_, project / ".keypose"),
      workshop_{disk_, hasher_, store_, records_, project} {
  hasher_.SetCancel([this] { return processes_.interrupted(); });
  file_ = ParsePipelineFile(disk_.Read(project / "pipeline.yaml"), "pipeline.yaml");
  const PipelineFile defaults =
      ParsePipelineFile(disk_.Read(DefaultPipelineFile(file_.kind)), "the default pipeline");
  graph_ =
      BuildGraph(Overlay(defaults, file_), overrides, {project, ProgramFolder()}, disk_, catalog_);
}

}  // namespace keypose::pipeline
