#include <gtest/gtest.h>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "register/nricp/nricp.h"
#include "register/quality/registration_quality.h"
#include "register/testing/scenes.h"

namespace keypose::registration::followed_bend_test {

TEST(RegisterNricp, FollowsAModestBendWithThirteenLandmarks) {
  const Mesh tube = MakeCylinder(0.12, 2, 20, 40), fine = MakeCylinder(0.12, 2, 23, 47);
  Mesh target = fine;
  target.points = Bent(fine.points, 2, 0.7);
  const PointsX3 truth = Bent(tube.points, 2, 0.7);
  const std::vector<LandmarkGoal> goals = Every(63, truth);
  const NricpResult result = RegisterNricp(tube, target, goals, {}, {});
  const double diagonal = BoundingDiagonal(target.points);
  EXPECT_LT((result.points - truth).rowwise().norm().mean() / diagonal,
            0.01);  // this method reaches 0.0087 on a bulb with a tentacle
  const RegistrationQuality q = MeasureRegistration(tube, result.points, target);
  EXPECT_EQ(q.flipped, 0);
  EXPECT_LT(q.surface_rms, 0.003);
}

}  // namespace keypose::registration::followed_bend_test
