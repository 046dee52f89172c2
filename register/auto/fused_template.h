// Handles of surfaces: a template and a pose of the same figure can differ in their number.
#pragma once

#include <optional>
#include <string>

#include "core/values/mesh.h"

namespace keypose::registration {

/// Number of handles of a closed surface, summed over all its pieces. Seams are welded first.
/// Empty for a surface with a boundary or with faults.
std::optional<int> HandlesOf(const Mesh& mesh);

/// Detects parts that touch in the template but are apart in the pose, which registration cannot
/// separate.
///
/// @param off_pose  largest distance of the registered template from the pose, over the pose's
/// diagonal
/// @return one sentence with the problem and what to do. Empty when the template has no more
/// handles than the pose, when either is open, or when off_pose is at most 0.01.
std::string FusedTemplateProblem(const Mesh& source, const Mesh& target, double off_pose);

}  // namespace keypose::registration
