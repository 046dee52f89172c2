// Steps with `when`: they exist only where the project gives what they need.
#pragma once

#include "pipeline/graph/sources.h"

namespace keypose::pipeline {

/// Whether the project, or one of its poses or shots, gives what the step exists for.
bool MayExist(const StepRule& rule, const Sources& sources, const std::vector<PoseRule>& poses);

/// Whether the project, or this pose or shot of it, gives what the step exists for.
/// @param pose  null: the step is of the animation or the project
/// @throws UsageError  `when` has what is no word of the table, or a pose's without one
bool IsWanted(const StepRule& rule, const Sources& sources, const PoseRule* pose);

}  // namespace keypose::pipeline
