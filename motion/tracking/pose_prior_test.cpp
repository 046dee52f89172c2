#include "motion/tracking/pose_prior.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

namespace keypose::motion::pose_prior_test {

/// The actor sits bent forward, with the left elbow inside of the left thigh.
BodyPose ElbowInThigh() {
  BodyPose pose;
  pose.q[Joints()[kWaist].first_dof] = 0.8;
  const int shoulder = Joints()[kShoulderL].first_dof, hip = Joints()[kHipL].first_dof;
  pose.q.segment<4>(shoulder) << 0.5, 0.75, -1.7, 1.5;
  pose.q[hip] = -2.0, pose.q[hip + 3] = 1.6;
  return pose;
}

TEST(AddOverlaps, AnElbowLeavesTheThigh) {
  const BodyShape shape = AverageShape();
  const auto apart = [&](const BodyPose& pose) {
    const PosedBody body = Posed(pose, shape);
    const Eigen::Vector3d hip = body.position[kHipL], elbow = body.position[kElbowL],
                          thigh = (body.position[kKneeL] - hip).normalized();
    return (elbow - hip).cross(thigh).norm();
  };
  BodyPose pose = ElbowInThigh();
  ASSERT_LT(apart(pose), 0.05);
  double cost = 0;
  for (int step = 0; step < 30; ++step) {
    PoseSystem system;
    AddOverlaps(Posed(pose, shape), shape, &system);
    cost = system.cost;
    system.matrix.diagonal().array() += 1e3;
    pose.q -= system.matrix.ldlt().solve(system.gradient);
  }
  EXPECT_LT(cost, 1);
  const double radii = shape.radii[5](3, 0) + shape.radii[10](3, 0);
  EXPECT_GT(apart(pose), 0.65 * radii);  // flesh gives way by 0.3
}

}  // namespace keypose::motion::pose_prior_test
