// Handles: what a template and a pose of it can differ in without being other figures.
#pragma once

#include <optional>
#include <string>

#include "core/mesh.h"

namespace keypose::registration {

/// Handles of a closed surface over all its pieces, seams welded; nothing for a surface with a
/// border or with faults.
std::optional<int> HandlesOf(const Mesh& mesh);

/// Why parts that touch in the template cannot come apart in the pose: one sentence with the cure.
/// Empty when the template has no handle that the pose lacks, when either is open, or when the
/// result lies on the pose all the same.
///
/// @param off_pose  farthest that the registered template lies off the pose, over the pose's
/// diagonal
std::string FusedTemplateProblem(const Mesh& source, const Mesh& target, double off_pose);

}  // namespace keypose::registration
