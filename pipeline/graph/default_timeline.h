// The timeline of a project that gives none.
#pragma once

#include <string>
#include <vector>

#include "pipeline/graph/override.h"
#include "pipeline/graph/pipeline_file.h"

namespace keypose::pipeline {

/// As in TimelineJson: the loop that the file's `default_timeline` asks for. Without it, where the
/// project gives its poses' order or says the option that `unless` names, and for fewer than two
/// keys: as OrderJson.
///
/// @param keys  the poses in order; of a loop the first follows at the end
std::string TimelineUnlessSaid(const PipelineFile& file, const std::vector<Override>& overrides,
                               std::vector<std::string>* keys);

}  // namespace keypose::pipeline
