// Sources that count only for a pair, such as landmarks: what is said where the template has one
// and the pose has none, or the other way round.
#pragma once

#include <string>
#include <vector>

#include "pipeline/graph/sources.h"

namespace keypose::pipeline {

/// @param poses  of a step: the template, and the pose
/// @throws InputError  a file that pipeline.yaml names is not there
void RequireNamedFiles(const Sources& sources, const SourceRule& rule,
                       const std::vector<const PoseRule*>& poses);

/// Of files that are not used, each with what to do.
/// @param all  the project's poses
std::vector<std::string> PairWarnings(const Sources& sources, const SourceRule& rule,
                                      const std::vector<const PoseRule*>& poses,
                                      const std::vector<PoseRule>& all);

}  // namespace keypose::pipeline
