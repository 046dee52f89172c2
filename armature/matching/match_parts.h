// What the ways to match a chain share.
#pragma once

#include "armature/matching/chain_match.h"
#include "armature/matching/closing.h"

namespace keypose::armature {

/// @throws InputError  no length, or one that is not positive and finite
void RequireLengths(const Eigen::VectorXd& lengths);

/// The chain from `start` on, with its distances from the curve.
ChainMatch Measured(const Polyline& curve, const Eigen::VectorXd& lengths,
                    const Directions& directions, const Eigen::Vector3d& start);

Directions DirectionsOf(const PointsX3& rows);

/// The rods' directions if each joint lay at its share of the curve's length.
Directions CurveDirections(const Polyline& curve, const Eigen::VectorXd& lengths);

}  // namespace keypose::armature
