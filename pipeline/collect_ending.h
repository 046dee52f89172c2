// Gathers what a person must know from the reports of a run's steps.
#pragma once

#include <filesystem>

#include "pipeline/disk.h"
#include "pipeline/ending.h"
#include "pipeline/plan.h"

namespace keypose::pipeline {

/// From what the steps' inputs warn of, and the reports beside the artifacts of all wanted steps
/// that are made, by this run or an earlier one; and of what they `show`, that which exists. A
/// report that is no JSON, or has no such fields, tells nothing.
/// @param out  the project's out/
Ending EndingOf(const Plan& plan, const Disk& disk, const std::filesystem::path& out);

}  // namespace keypose::pipeline
