#include "motion/tracking/pose_search.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include "motion/tracking/testing/filmed_body.h"

namespace keypose::motion::pose_search_test {

TEST(SearchPoses, FindsHeadingAndArmsFromNothing) {
  const BodyShape shape = AverageShape();
  BodyPose truth = Standing();
  truth.root_chart = Eigen::Quaterniond(Eigen::AngleAxisd(2.2, Eigen::Vector3d::UnitZ()));
  const std::vector<Silhouette> silhouettes = Filmed(Ring(8), shape, truth);
  const Eigen::Quaterniond up = Eigen::Quaterniond::Identity();
  const CoarseHull hull = FindCoarseHull(silhouettes, up);
  EXPECT_NEAR(hull.high.z() - hull.low.z(), 1.78, 0.12);
  const std::vector<BodyPose> poses = SearchPoses(silhouettes, hull, up, shape, 2);
  EXPECT_LT(WorstJoint(poses.front(), truth, shape), 0.06);
}

TEST(SearchLimb, FindsAnArmThatWasLost) {
  const BodyShape shape = AverageShape();
  const std::vector<Silhouette> silhouettes = Filmed(Ring(8), shape, Standing());
  BodyPose lost = Standing();
  const int shoulder = Joints()[kShoulderR].first_dof;
  lost.q.segment<4>(shoulder) << 0.3, 1.0, 0.6, 0.1;
  const LocalSurface surface = SurfaceOf(shape);
  const BodyPose found = SearchLimb(silhouettes, shape, surface, lost, Limb::kRightArm, 1).front();
  PoseOptions options;
  options.rounds = 10, options.first_reach = 20, options.priors = {RestPrior()};
  EXPECT_LT(
      WorstJoint(SolvePose(silhouettes, shape, surface, found, options).pose, Standing(), shape),
      0.03);
}

TEST(TurnedAround, JointsStayWhereTheyWereAndTheHingeBendsTheOtherWay) {
  const BodyShape shape = AverageShape();
  BodyPose pose = Standing();
  pose.q[Joints()[kElbowL].first_dof] = -0.7;
  pose.q[Joints()[kKneeR].first_dof] = -0.4;
  EXPECT_DOUBLE_EQ(BentBackwards(pose, Limb::kLeftArm), 0.7);
  EXPECT_DOUBLE_EQ(BentBackwards(pose, Limb::kRightArm), 0);
  for (const Limb limb : {Limb::kLeftArm, Limb::kRightLeg}) {
    const BodyPose around = TurnedAround(pose, limb);
    EXPECT_EQ(BentBackwards(around, limb), 0);
    EXPECT_LT(WorstJoint(around, pose, shape), 1e-12);
  }
}

}  // namespace keypose::motion::pose_search_test
