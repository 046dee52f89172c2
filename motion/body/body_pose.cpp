#include "motion/body/body_pose.h"

#include <cmath>

namespace keypose::motion {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d Cross(const Vector3d& w) {
  Matrix3d m;
  m << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  return m;
}

Vector3d OffsetOf(const JointModel& joint, const BodyShape& shape) {
  Vector3d offset = Vector3d::Zero();
  for (const auto& [length, direction] : joint.offset) offset += shape.lengths[length] * direction;
  return offset;
}

/// The joint's own rotation, and its turns, in a frame whose rotation in the world is `parent`.
Matrix3d TurnJoint(const JointModel& joint, const DofVector& q, const Matrix3d& parent,
                   std::vector<PosedBody::Turn>* turns) {
  if (joint.ball) {
    const Vector3d w = joint.share * q.segment<3>(joint.first_dof);
    const Matrix3d axes = joint.share * parent * LeftJacobian(w);
    for (int k = 0; k < 3; ++k) turns->push_back({joint.first_dof + k, axes.col(k)});
    return RotationOf(w);
  }
  Matrix3d rotation = Matrix3d::Identity();
  for (std::size_t k = 0; k < joint.hinges.size(); ++k) {
    const int dof = joint.first_dof + static_cast<int>(k);
    turns->push_back({dof, parent * rotation * joint.hinges[k]});
    rotation = rotation * RotationOf(q[dof] * joint.hinges[k]);
  }
  return rotation;
}

}  // namespace

BodyPose MarkingPose() {
  constexpr double kLowered = 0.7, kApart = 0.2;  // [rad]
  BodyPose pose;
  for (int i = 0; i < kDofs; ++i) {
    const std::string& name = Dofs()[i].name;
    const double side = name.starts_with("left_") ? 1 : -1;
    if (name.ends_with("_shoulder_lower")) pose.q[i] = side * kLowered;
    if (name.ends_with("_hip_in")) pose.q[i] = -side * kApart;
  }
  return pose;
}

Matrix3d RotationOf(const Vector3d& w) {
  const double angle = w.norm();
  const Matrix3d cross = Cross(w);
  // Series near zero, where the quotients lose their digits.
  const double a = angle < 1e-5 ? 1 - angle * angle / 6 : std::sin(angle) / angle;
  const double b =
      angle < 1e-4 ? 0.5 - angle * angle / 24 : (1 - std::cos(angle)) / (angle * angle);
  return Matrix3d::Identity() + a * cross + b * cross * cross;
}

Matrix3d LeftJacobian(const Vector3d& w) {
  const double angle = w.norm(), squared = angle * angle;
  const Matrix3d cross = Cross(w);
  const double b = angle < 1e-4 ? 0.5 - squared / 24 : (1 - std::cos(angle)) / squared;
  const double c =
      angle < 1e-2 ? 1.0 / 6 - squared / 120 : (angle - std::sin(angle)) / (squared * angle);
  return Matrix3d::Identity() + b * cross + c * cross * cross;
}

Eigen::Quaterniond BodyPose::RootRotation() const {
  return (Eigen::Quaterniond(RotationOf(q.segment<3>(3))) * root_chart).normalized();
}

BodyPose BodyPose::Recharted() const {
  BodyPose pose = *this;
  pose.root_chart = RootRotation();
  pose.q.segment<3>(3).setZero();
  return pose;
}

void Repose(const BodyPose& pose, const BodyShape& shape, int first, int last, PosedBody* body) {
  for (int j = first; j <= last; ++j) {
    const JointModel& joint = Joints()[j];
    body->turns[j].clear();
    if (joint.parent < 0) {
      // The chart comes first: the root's numbers turn it in the world.
      const Matrix3d turn = TurnJoint(joint, pose.q, Matrix3d::Identity(), &body->turns[j]);
      body->rotation[j] = turn * pose.root_chart.toRotationMatrix();
      body->position[j] = pose.q.head<3>();
      continue;
    }
    const Matrix3d& parent = body->rotation[joint.parent];
    body->rotation[j] = parent * TurnJoint(joint, pose.q, parent, &body->turns[j]);
    body->position[j] = body->position[joint.parent] + parent * OffsetOf(joint, shape);
  }
}

PosedBody Posed(const BodyPose& pose, const BodyShape& shape) {
  PosedBody body;
  Repose(pose, shape, 0, kJoints - 1, &body);
  return body;
}

void PosedBody::AddPoseRow(int joint, const Vector3d& x, const Vector3d& w, double* row) const {
  for (int k = 0; k < 3; ++k) row[k] += w[k];
  for (const int j : ChainOf(joint)) {
    // w . (axis x arm) = axis . (arm x w)
    const Vector3d moment = (x - position[j]).cross(w);
    for (const Turn& turn : turns[j]) row[turn.dof] += turn.axis.dot(moment);
  }
}

void PosedBody::AddLengthRow(int joint, const Vector3d& w, double* row) const {
  for (const int j : ChainOf(joint)) {
    const JointModel& model = Joints()[j];
    if (model.parent < 0) continue;
    const Vector3d in_parent = rotation[model.parent].transpose() * w;
    for (const auto& [length, direction] : model.offset) row[length] += in_parent.dot(direction);
  }
}

}  // namespace keypose::motion
