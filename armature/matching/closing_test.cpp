#include "armature/matching/closing.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
namespace keypose::armature::closing_test {

using Eigen::Vector3d;

TEST(CloseChain, CircleReachesEveryReachableDistance) {
  const Eigen::Vector4d lengths(0.3, 2, 1.1, 0.4);
  for (double distance = 0.2001; distance < 3.8; distance += 0.1) {
    const Vector3d span = distance * Vector3d(1, 2, -1).normalized();
    ASSERT_EQ(ReachOf(lengths, distance), Reach::kReachable) << distance;
    const Directions u = RodsOnCircle(lengths, span, Vector3d::UnitX());
    Vector3d sum = Vector3d::Zero();
    for (int i = 0; i < 4; ++i) sum += lengths[i] * u[i];
    EXPECT_LT((sum - span).norm(), 1e-9) << distance;
  }
  EXPECT_EQ(ReachOf(lengths, 0.19), Reach::kTooNear);
  EXPECT_EQ(ReachOf(lengths, 3.81), Reach::kTooFar);
}

}  // namespace keypose::armature::closing_test
