// How the target holds its limbs at rest, against the template.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/values/mesh.h"
#include "motion/fields/mark_turns.h"

namespace keypose::motion {

/// The turn of each mark's surroundings from the target's reference pose to the template's.
///
/// The vectors from a mark to the marks nearest to it, on both meshes, give a turn (Procrustes,
/// with a pull towards none). It is averaged over the neighbours, so that only what whole limbs do
/// is left, and not the shape of the surface; under 10 degrees it fades out, as bodies of other
/// shapes differ by that much in the same pose.
/// @param on_template  M x 3, marks in the template's reference pose, in the target's directions
/// @param on_target    M x 3
/// @return M; identity where the poses agree
std::vector<Eigen::Quaterniond> RestTurns(const MarkTree& tree, const PointsX3& on_template,
                                          const PointsX3& on_target);

}  // namespace keypose::motion
