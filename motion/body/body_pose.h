// Poses of the kinematic template: joints in the world, and their analytic derivatives.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "motion/body/body_template.h"

namespace keypose::motion {

using DofVector = Eigen::Matrix<double, kDofs, 1>;

/// The 38 numbers of a pose. Numbers 3 to 5 turn the root from `root_chart`, which keeps them small
/// while the actor turns round and round.
struct BodyPose {
  DofVector q = DofVector::Zero();  ///< [m] for the first three, else [rad]
  Eigen::Quaterniond root_chart = Eigen::Quaterniond::Identity();

  Eigen::Quaterniond RootRotation() const;
  /// The same pose with numbers 3 to 5 zero.
  BodyPose Recharted() const;
};

/// Upright, arms lowered by 40 degrees, legs apart: as scans stand, to pick marks on.
BodyPose MarkingPose();

/// exp(w) as a matrix.
Eigen::Matrix3d RotationOf(const Eigen::Vector3d& w);
/// J with exp(w + dw) = exp(J dw) exp(w) for small dw.
Eigen::Matrix3d LeftJacobian(const Eigen::Vector3d& w);

/// Joints in the world, and what moves them.
struct PosedBody {
  /// A number of the pose turns all that hangs on `joint` about an axis through it.
  struct Turn {
    int dof = 0;
    Eigen::Vector3d axis;  ///< [rad/rad] in world; not of unit length
  };
  std::array<Eigen::Matrix3d, kJoints> rotation;  ///< world from joint
  std::array<Eigen::Vector3d, kJoints> position;  ///< in world [m]
  std::array<std::vector<Turn>, kJoints> turns;

  Eigen::Vector3d ToWorld(int joint, const Eigen::Vector3d& x_in_joint) const {
    return rotation[joint] * x_in_joint + position[joint];
  }
  /// Adds w^T d(x)/d(q), where x is fixed to `joint` at `x_in_world`.
  void AddPoseRow(int joint, const Eigen::Vector3d& x_in_world, const Eigen::Vector3d& w,
                  double* row) const;
  /// Adds w^T d(position[joint])/d(lengths).
  void AddLengthRow(int joint, const Eigen::Vector3d& w, double* row) const;
};
PosedBody Posed(const BodyPose& pose, const BodyShape& shape);
/// Poses the joints from `first` to `last` anew; their parents outside of these stay as they are.
void Repose(const BodyPose& pose, const BodyShape& shape, int first, int last, PosedBody* body);

}  // namespace keypose::motion
