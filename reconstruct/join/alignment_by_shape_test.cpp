#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "reconstruct/join/model_alignment.h"
#include "reconstruct/join/testing/half_seen.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::alignment_by_shape_test {

using Eigen::Vector3d;
using testing::PointAt;

TEST(AlignByShape, HalvesThatShareNoFeatureAreTurnedOntoEachOther) {
  Similarity3 lying;
  lying.rotation = Eigen::AngleAxisd(1.7, Vector3d(1, 0.2, 0.1).normalized()).toRotationMatrix();
  lying.translation = Vector3d(0.05, -0.1, 0.04);
  const Scene first = HalfSeen(-Vector3d::UnitZ(), {}, 1),
              second = HalfSeen(Vector3d::UnitY(), lying, 2);
  const ModelAlignment join = AlignByShape(first, second, {});
  ASSERT_TRUE(join.found) << join.agreeing << " of " << join.pairs;
  const Similarity3 truth = lying.Inverse();
  EXPECT_LT(
      (join.first_from_second.rotation.transpose() * truth.rotation - Eigen::Matrix3d::Identity())
          .norm(),
      0.02);
  EXPECT_LT((join.first_from_second * Vector3d(0.05, -0.1, 0.1) - truth * Vector3d(0.05, -0.1, 0.1))
                .norm(),
            0.001);
}

TEST(AlignByShape, PlainBallIsNotJoinedSinceAnyTurnFits) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 1);
  Scene ball;
  for (int i = 0; i < 2000; ++i)
    ball.points.push_back(
        PointAt(Vector3d(normal(random), normal(random), normal(random)).normalized()));
  EXPECT_FALSE(AlignByShape(ball, ball, {}).found);
}

}  // namespace keypose::reconstruct::alignment_by_shape_test
