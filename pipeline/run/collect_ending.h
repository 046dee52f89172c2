// Collects the warnings, verdicts and results of a run from its steps' reports.
#pragma once

#include <filesystem>

#include "pipeline/cache/ending.h"
#include "pipeline/disk/disk.h"
#include "pipeline/run/plan.h"

namespace keypose::pipeline {

/// Collects the warnings about the steps' inputs, the reports of all wanted steps whose artifacts
/// are in the cache (made by this run or an earlier one), and those results listed under `show`
/// that exist. A report that is not JSON, or lacks these fields, is ignored.
/// @param out  the project's out/
Ending EndingOf(const Plan& plan, const Disk& disk, const std::filesystem::path& out);

/// What a step said when it made the artifact; the same words of several steps become one warning.
void AddWarnings(const Artifact& artifact, const Step& step, const Disk& disk,
                 std::vector<RunWarning>* warnings);

}  // namespace keypose::pipeline
