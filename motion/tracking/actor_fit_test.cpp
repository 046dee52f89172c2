#include "motion/tracking/actor_fit.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include "motion/tracking/pose_search.h"
#include "motion/tracking/testing/filmed_body.h"

namespace keypose::motion::actor_fit_test {

TEST(FitActor, FindsLengthsAndGirthsOfAnotherBody) {
  BodyShape truth = Scaled(AverageShape(), 1.06);
  truth.lengths[kThigh] *= 1.05, truth.lengths[kThigh + kRight] *= 1.05;
  for (const int s : {0, 1, 2}) truth.radii[s].col(0) *= 1.2;
  std::vector<ActorFrame> frames;
  for (const double bend : {0.1, 0.9}) {
    BodyPose pose = Standing();
    for (const int knee : {kKneeL, kKneeR}) pose.q[Joints()[knee].first_dof] = bend;
    for (const int elbow : {kElbowL, kElbowR}) pose.q[Joints()[elbow].first_dof] = bend;
    frames.push_back({Filmed(Ring(8), truth, pose), pose, {RestPrior()}});
  }
  BodyShape shape = AverageShape();
  ActorOptions options;
  options.rounds = 15;
  FitActor(&frames, &shape, options);
  EXPECT_NEAR(shape.height(), truth.height(), 0.03);
  EXPECT_NEAR(shape.lengths[kThigh], truth.lengths[kThigh], 0.02);
  for (const int s : {0, 1, 2})
    EXPECT_NEAR(shape.radii[s].col(0).mean(), truth.radii[s].col(0).mean(), 0.012);
  for (const ActorFrame& frame : frames)
    EXPECT_GT(CoverageOf(frame.silhouettes, SurfaceOf(shape), Posed(frame.pose, shape)).IoU(),
              0.95);
}

}  // namespace keypose::motion::actor_fit_test
