// Rods of fixed lengths whose sum is a given vector.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace keypose::armature {

using Directions = std::vector<Eigen::Vector3d>;

/// Whether rods of these lengths can reach from one end of `span` to the other, and how they lie
/// when they only just can, or cannot.
enum class Reach { kReachable, kTooFar, kTooNear };
/// @param distance  between the two ends
Reach ReachOf(const Eigen::VectorXd& lengths, double distance);

/// Turns the rods as little as possible until they end at `span` (Newton with steps of least norm).
/// @param directions  M unit vectors; changed
/// @return whether |sum - span| <= 1e-14 of the rods' length was reached, or all that rounding lets
bool CloseChain(const Eigen::VectorXd& lengths, const Eigen::Vector3d& span,
                Directions& directions);

/// Rods on a circle, in the plane of `span` and `side`: a chain that ends at `span` whenever one
/// exists. If `side` lies along `span`, the circle bulges upwards (z), or along y if they stand
/// upright.
/// @pre ReachOf(lengths, |span|) is kReachable
Directions RodsOnCircle(const Eigen::VectorXd& lengths, const Eigen::Vector3d& span,
                        const Eigen::Vector3d& side);

}  // namespace keypose::armature
