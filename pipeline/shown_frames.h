// Whether the film of a shot has the frames that it is said to show poses in.
#pragma once

#include <filesystem>

#include "pipeline/disk.h"
#include "pipeline/pipeline_file.h"

namespace keypose::pipeline {

/// Looks at a film that is a folder of numbered pictures. Others are left to `locate`.
/// @throws UsageError  a frame of `shows` is none of the film's; names the line, and how frames
/// count
void CheckShownFrames(const PipelineFile& file, const std::filesystem::path& project,
                      const Disk& disk);

}  // namespace keypose::pipeline
