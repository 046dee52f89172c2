// Builds the graph: the pipeline file's rules fanned out over poses, with every input, option and
// result checked.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/disk.h"
#include "pipeline/graph.h"
#include "pipeline/pipeline_file.h"
#include "pipeline/stage_catalog.h"

namespace keypose::pipeline {

/// --set STEP.OPTION=V or STEP/POSE.OPTION=V
struct Override {
  std::string step, pose, option, value;
};
/// @throws UsageError  not of that form
Override ParseOverride(const std::string& text);

/// Where things are.
struct Places {
  std::filesystem::path project;       ///< its root folder
  std::filesystem::path stage_folder;  ///< has the programs keypose-STAGE
};

/// Checks and builds all. Asks the stages of all enabled steps to describe themselves.
///
/// @throws UsageError  a step, pose, port, option or reference that does not exist, a wrong type, a
/// cycle, two steps that write one
///                     result; with file:line
/// @throws ToolError   a stage cannot be asked
Graph BuildGraph(const PipelineFile& file, const std::vector<Override>& overrides,
                 const Places& places, const Disk& disk, StageCatalog& catalog);

}  // namespace keypose::pipeline
