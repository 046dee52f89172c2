#include "motion/tracking/tracker.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include "motion/tracking/testing/filmed_body.h"

namespace keypose::motion::tracker_test {

TEST(Tracker, AnElbowThatWasFollowedTheWrongWayIsTurnedAround) {
  const BodyShape shape = AverageShape();
  const std::vector<View> views = Ring(6);
  BodyPose truth = Standing();
  truth.q[Joints()[kElbowL].first_dof] = 0.9;
  const std::vector<Silhouette> silhouettes = Filmed(views, shape, truth);
  const BodyPose wrong = TurnedAround(truth, Limb::kLeftArm);
  ASSERT_NEAR(BentBackwards(wrong, Limb::kLeftArm), 0.9, 1e-12);
  Tracker tracker(shape, wrong);
  const TrackedFrame frame = tracker.Next(silhouettes);
  EXPECT_EQ(frame.found, std::vector<Limb>{Limb::kLeftArm});
  EXPECT_NEAR(frame.pose.q[Joints()[kElbowL].first_dof], 0.9, 0.15);  // pixels are 8 mm
}

TEST(FrameEvidence, IsThatOfTheRechartedPose) {
  const BodyShape shape = AverageShape();
  BodyPose pose = Standing();
  pose.q.segment<3>(3) = Eigen::Vector3d(0.3, -0.2, 0.5);
  pose.q[Joints()[kElbowL].first_dof] = -0.2;  // beyond a limit
  const std::vector<Silhouette> silhouettes = Filmed(Ring(4), shape, pose);
  PoseOptions options;
  options.rounds = 1, options.steps = 0;
  const auto evidence = [&](const BodyPose& at) {
    return FrameEvidence(SolvePose(silhouettes, shape, SurfaceOf(shape), at, options), shape);
  };
  const PoseSystem moved = evidence(pose), direct = evidence(pose.Recharted());
  EXPECT_LT((moved.matrix - direct.matrix).norm(), 1e-6 * direct.matrix.norm());
  EXPECT_LT((moved.gradient - direct.gradient).norm(), 1e-6 * direct.gradient.norm());
}

}  // namespace keypose::motion::tracker_test
