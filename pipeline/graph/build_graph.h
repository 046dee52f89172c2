// Builds the graph: applies the rules of the pipeline file to all poses and checks every input,
// option and result.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/disk/disk.h"
#include "pipeline/graph/graph.h"
#include "pipeline/graph/override.h"
#include "pipeline/graph/pipeline_file.h"
#include "pipeline/graph/stage_catalog.h"

namespace keypose::pipeline {

/// @throws UsageError  not of that form
Override ParseOverride(const std::string& text);

/// Folders that the graph refers to.
struct Places {
  std::filesystem::path project;       ///< the project's root folder
  std::filesystem::path stage_folder;  ///< contains the programs keypose-STAGE
};

/// Builds and checks the graph. Runs the stages of all enabled steps with --describe.
///
/// @throws UsageError  a step, pose, port, option or reference does not exist, a type is wrong, the
/// steps form a cycle, or two steps write the same result; with file:line
/// @throws ToolError   a stage cannot be described
Graph BuildGraph(const PipelineFile& file, const std::vector<Override>& overrides,
                 const Places& places, const Disk& disk, StageCatalog& catalog);

}  // namespace keypose::pipeline
