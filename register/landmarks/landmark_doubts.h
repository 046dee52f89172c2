// Warnings about landmark pairs that are valid but look wrong.
#pragma once

#include <string>
#include <vector>

#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"

namespace keypose::registration {

/// Looks for three kinds of mistakes. The result is warnings, not errors, because any pose is
/// allowed.
///
/// - Swapped: distances along the surface fit much better with two targets exchanged.
/// - Misplaced: one landmark's distances to most others change far more than the rest.
/// - Mirrored: the landmarks fit far better after a reflection, as when left and right are
///   exchanged everywhere.
///
/// Needs four landmarks, for mirrored five. The first two are skipped when a mesh has more than
/// `kLargestForDistances` vertices.
/// @param goals  checked: on the source, without repeats
/// @return one sentence for each problem, which names the landmarks; empty when all looks right
/// Deterministic.
/// Cost: one shortest-path search for each landmark and mesh.
std::vector<std::string> WarningsAbout(const std::vector<LandmarkGoal>& goals, const Mesh& source,
                                       const Mesh& target);

constexpr int kLargestForDistances = 60000;

}  // namespace keypose::registration
