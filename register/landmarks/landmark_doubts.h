// What looks wrong about landmark pairs that are formally in order.
#pragma once

#include <string>
#include <vector>

#include "core/landmark_goal.h"
#include "core/mesh.h"

namespace keypose::registration {

/// Sentences that name landmarks, empty when nothing is suspicious. A pose may be as odd as it
/// likes, so these are never errors.
///
/// Swapped: exchanging the targets of two landmarks would make distances along the surface fit much
/// better. Misplaced: one landmark's distances to most others change far more than those between
/// the others. Mirrored: the landmarks fit far better after a reflection, as when left and right
/// are exchanged throughout. Needs four landmarks or more, for mirrored five; distances are not
/// looked at on meshes of more than `kLargestForDistances` vertices.
/// @param goals  checked: on the source, without repeats
/// Deterministic.
/// Cost: one shortest-path search for each landmark on either mesh.
std::vector<std::string> DoubtsAbout(const std::vector<LandmarkGoal>& goals, const Mesh& source,
                                     const Mesh& target);

constexpr int kLargestForDistances = 60000;

}  // namespace keypose::registration
