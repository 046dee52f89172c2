// What a project's pipeline file says, over what the default one says.
#pragma once

#include "pipeline/graph/pipeline_file.h"

namespace keypose::pipeline {

/// Merges `project` over `defaults`: its steps add to, change or disable steps of the same name,
/// its sources are added. Everything else is taken from `project`.
PipelineFile Overlay(const PipelineFile& defaults, const PipelineFile& project);

}  // namespace keypose::pipeline
