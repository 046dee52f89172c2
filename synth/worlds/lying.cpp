#include "synth/worlds/lying.h"

#include <Eigen/LU>

namespace keypose::synth {

Lying LayDown(const Pose& standing_pose, const PointsX3& standing) {
  constexpr double kQuarter = -1.5707963267948966;
  const Eigen::AngleAxisd turn(kQuarter, Eigen::Vector3d::UnitX());
  const PointsX3 turned = standing * turn.toRotationMatrix().transpose();
  const Eigen::RowVector3d low = turned.colwise().minCoeff(), high = turned.colwise().maxCoeff();
  const Eigen::Vector3d shift(0, -(low[1] + high[1]) / 2, -low[2]);
  // The same motion as a rotation about an axis along x. Its centre c solves (I - R) c = shift in
  // the y-z plane.
  const Eigen::Matrix2d plane =
      (Eigen::Matrix3d::Identity() - turn.toRotationMatrix()).bottomRightCorner<2, 2>();
  const Eigen::Vector2d center = plane.inverse() * shift.tail<2>();
  Deformation rigid;
  rigid.kind = Deformation::Kind::kTwist;
  rigid.axis = Eigen::Vector3d::UnitX();
  rigid.origin = Eigen::Vector3d(0, center[0], center[1]);
  rigid.begin = -1e6;
  rigid.end = -1e5;  // the whole character lies beyond `end`, so the full angle applies everywhere
  rigid.angle = kQuarter;
  Lying lying{standing_pose, {Eigen::Quaterniond(turn), shift}};
  lying.pose.steps.push_back(rigid);
  return lying;
}

}  // namespace keypose::synth
