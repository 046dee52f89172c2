// How the rods of a physical chain carry what is laid along them: turns of the computer's rods,
// with the twist of the armature.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "armature/matching/polyline.h"

namespace keypose::armature {

/// The turn that each of M parts of a curve has on average, weighted by length.
///
/// @param turns    of the curve's P-1 pieces, against the zero position
/// @param lengths  M; the curve is shared out in their proportion
/// @return M unit quaternions
std::vector<Eigen::Quaterniond> TurnsAlong(const Polyline& curve,
                                           const std::vector<Eigen::Quaterniond>& turns,
                                           const Eigen::VectorXd& lengths);

/// The turn that has the least angle and takes unit vector `from` to `to`, after `turn`. Parallel
/// transport from one direction to the other: it adds no twist.
Eigen::Quaterniond Redirected(const Eigen::Quaterniond& turn, const Eigen::Vector3d& from,
                              const Eigen::Vector3d& to);

}  // namespace keypose::armature
