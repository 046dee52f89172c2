#include "capture/room/room_evidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "capture/room/testing/scattered_points.h"
#include "capture/testing/test_ring.h"

namespace keypose::capture::room_evidence_test {

/// A floor through the ball's middle: its middle part is in the masks.
void AddFloor(Scene& scene, int count) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int k = 0; k < count; ++k) Add(scene, {2 * unit(random), 2 * unit(random), 0});
}

TEST(LookAround, PointsOnTheFigureAloneAreNoRoom) {
  const TestRing ring = MakeTestRing();
  Scene scene = SceneWith(ring);
  AddBall(scene, 300);
  const RoomEvidence evidence = LookAround(scene, ring.truths);
  EXPECT_FALSE(evidence.in_room);
  EXPECT_FALSE(evidence.floor);
  EXPECT_LT(evidence.around, 0.01);
}

TEST(LookAround, ATableAroundTheFigureIsARoomWithAFloor) {
  const TestRing ring = MakeTestRing();
  Scene scene = SceneWith(ring);
  AddBall(scene, 300);
  AddFloor(scene, 300);
  const RoomEvidence evidence = LookAround(scene, ring.truths);
  EXPECT_TRUE(evidence.in_room);
  EXPECT_TRUE(evidence.floor);
  EXPECT_NEAR(evidence.around, 0.5 * (1 - 3.14159 * 0.7 * 0.7 / 16), 0.05);
  EXPECT_TRUE(evidence.floor_in_masks);  // the ball's masks hold the floor's middle
}

TEST(LookAround, WithoutPointsNothingIsSaid) {
  const TestRing ring = MakeTestRing();
  EXPECT_FALSE(LookAround(SceneWith(ring), ring.truths).in_room);
}

}  // namespace keypose::capture::room_evidence_test
