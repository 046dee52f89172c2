// Whether the film of a shot has the frames that it is said to show poses in, and the timeline keys
// there.
#pragma once

#include <filesystem>

#include "pipeline/disk/disk.h"
#include "pipeline/graph/pipeline_file.h"

namespace keypose::pipeline {

/// Looks at a film that is a folder of numbered pictures. Others are left to `locate`.
/// @throws UsageError  the shot has no film or shows fewer than two frames, or one of them is none
/// of the film's; names the line, and how frames count
void CheckShownFrames(const PipelineFile& file, const std::filesystem::path& project,
                      const Disk& disk);

/// A timeline of the project's own must have a key where the film shows a pose: what is rendered
/// stands between what was filmed. Without times, the frames between keys decide, which `composite`
/// compares.
/// @throws UsageError  a shown pose without a key at its frame's time; names the line and the time
void CheckShownTimes(const PipelineFile& file);

}  // namespace keypose::pipeline
