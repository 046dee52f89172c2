#include "reconstruct/turntable/ring_start.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/numbers/parallel.h"
#include "reconstruct/turntable/testing/ring_world.h"

namespace keypose::reconstruct::ring_start_test {

// 12 matches per pair, a third of them wrong: no pair could be verified on its own.
TEST(FindRingModel, FewMatchesOfTwoRingsWithWrongOnesAmongThem) {
  RingWorld world = MakeWorld({12, 40}, 18, 200, 0.5);
  const auto pairs = MakePairs(world, 0.5, 0.33, 12);
  const RingStart start = FindRingModel(world.truth.camera, LayoutOfSizes(36, {18, 18}), pairs);
  EXPECT_TRUE(start.IsPlausible());
  EXPECT_NEAR(start.inlier_share, 0.67, 0.05);
  EXPECT_LT(CenterError(Centers(start.model), Centers(world.truth)), 0.02);
}

TEST(FindRingModel, MatchesOfNothingAreNotBelieved) {
  RingWorld world = MakeWorld({25}, 12, 100, 0);
  const auto pairs = MakePairs(world, 0.5, 1.0, 12);
  EXPECT_FALSE(FindRingModel(world.truth.camera, LayoutOfSizes(12, {12}), pairs).IsPlausible());
}

TEST(FindRingModel, SameBitsForAnyThreadCount) {
  RingWorld world = MakeWorld({25}, 12, 60, 0.3);
  const auto pairs = MakePairs(world, 0.5, 0.2, 10);
  SetThreadCount(1);
  const RingStart one = FindRingModel(world.truth.camera, LayoutOfSizes(12, {12}), pairs);
  SetThreadCount(3);
  const RingStart three = FindRingModel(world.truth.camera, LayoutOfSizes(12, {12}), pairs);
  SetThreadCount(0);
  EXPECT_EQ(Centers(one.model), Centers(three.model));
}

}  // namespace keypose::reconstruct::ring_start_test
