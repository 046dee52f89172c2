// Rotations as matrices, quaternions and rotation vectors, also of more than half a turn.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace keypose {

/// Rotation vector of a rotation, |w| <= pi [rad], exact near 0 and near pi. A quaternion and its
/// negative, which is the same rotation, give the same vector.
Eigen::Vector3d LogOf(const Eigen::Matrix3d& rotation);
Eigen::Vector3d LogOf(const Eigen::Quaterniond& unit);
Eigen::Matrix3d ExpOf(const Eigen::Vector3d& turn);
Eigen::Quaterniond QuaternionOf(const Eigen::Vector3d& turn);

/// sin^2 of half the angle between two rotations. It orders rotations as the angle does, without
/// arccosines.
double RotationDifference(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);
/// The angle [rad] of a RotationDifference.
double AngleOfDifference(double sine2);

/// The rotation vector of `rotation`, of any length, that continues `before`: a vector of
/// `before_rotation`, which is a rotation near by in space or time. Whole turns about the axis are
/// added so that the two vectors are as near as possible. Beyond 200 degrees the axis of a rotation
/// becomes uncertain, and at 360 degrees it is undefined. There the result is one Newton step from
/// `before` to the rotation, damped across the axis, and only nearly a vector of it.
/// Source: as-consistent-as-possible axis-angle, Gao et al., TVCG 2019, for the lift; the damped
/// step is our own (docs/algorithms/interpolate.md).
Eigen::Vector3d TurnAfter(const Eigen::Vector3d& before, const Eigen::Quaterniond& before_rotation,
                          const Eigen::Quaterniond& rotation);

}  // namespace keypose
