// What would fail at the end of a run, looked for before its first step begins.
#pragma once

#include "pipeline/disk/process.h"
#include "pipeline/graph/pipeline_file.h"
#include "pipeline/run/plan.h"

namespace keypose::pipeline {

/// Looks at what the steps that may run take:
/// - the timeline: a loop that does not close, two keys in one frame, pins where no key is
/// - the film of a shot: a shown pose without a key at its time
/// - options that a range cannot describe, such as lists of names: their stages are asked
///
/// @param file  the project's own, for the lines of its timeline
/// @throws UsageError  with the line, or the step, and what to do
void RequireRunnable(const Plan& plan, const PipelineFile& file, ProcessRunner& processes);

}  // namespace keypose::pipeline
