// A project opened for a command: its files, graph, cache and records, with the real disk and
// processes.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/cache/artifact_store.h"
#include "pipeline/cache/records.h"
#include "pipeline/disk/clock.h"
#include "pipeline/disk/real_disk.h"
#include "pipeline/disk/real_process.h"
#include "pipeline/graph/build_graph.h"
#include "pipeline/graph/graph.h"
#include "pipeline/run/plan.h"

namespace keypose::pipeline {

/// The running program's folder.
std::filesystem::path ProgramFolder();
/// The default pipeline of such projects that was installed with the program.
/// @throws DiskError  it is missing
std::filesystem::path DefaultPipelineFile(ProjectKind kind);

/// The project's root: `folder`; if that is empty, the current folder or its nearest parent that
/// has a pipeline.yaml.
/// @throws UsageError  there is none
/// @throws DiskError  its pipeline.yaml is not a file, or its .keypose is a link that leads out of
/// the project
std::filesystem::path FindProject(const std::string& folder);

class OpenedProject {
 public:
  /// Reads pipeline.yaml, merges it over the default pipeline, and builds the graph.
  /// @throws as ParsePipelineFile and BuildGraph
  /// @param catch_signals  true for commands that run steps; see RealProcessRunner
  OpenedProject(const std::filesystem::path& project, const std::vector<Override>& overrides,
                bool catch_signals = false);

  const std::filesystem::path& project() const { return project_; }
  std::filesystem::path state() const { return project_ / ".keypose"; }
  std::filesystem::path out() const { return project_ / "out"; }
  /// pipeline.yaml as the project has it, without the default pipeline.
  const PipelineFile& file() const { return file_; }
  const Graph& graph() const { return graph_; }
  RealDisk& disk() { return disk_; }
  RealProcessRunner& processes() { return processes_; }
  ArtifactStore& store() { return store_; }
  Records& records() { return records_; }
  Workshop& workshop() { return workshop_; }
  const RealClock& clock() const { return clock_; }

 private:
  std::filesystem::path project_;
  RealDisk disk_;
  RealProcessRunner processes_;
  RealClock clock_;
  StageCatalog catalog_;
  ContentHasher hasher_;
  ArtifactStore store_;
  Records records_;
  PipelineFile file_;
  Graph graph_;
  Workshop workshop_;
};

}  // namespace keypose::pipeline
