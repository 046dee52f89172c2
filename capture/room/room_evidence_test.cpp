#include "capture/room/room_evidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "capture/room/free_standing.h"
#include "capture/testing/test_ring.h"

namespace keypose::capture::room_evidence_test {

Scene SceneWith(const TestRing& ring) {
  Scene scene;
  scene.views = ring.views;
  return scene;
}

void Add(Scene& scene, const Eigen::Vector3d& x) {
  SparsePoint point;
  point.position = x;
  point.color.setZero();
  for (int v = 0; v < kRingViews; v += 3) point.views.push_back(v);
  scene.points.push_back(point);
}

void AddBall(Scene& scene, int count) {
  std::mt19937 random(2);
  std::normal_distribution<double> gauss(0, 1);
  for (int k = 0; k < count; ++k)
    Add(scene, 0.6 * Eigen::Vector3d(gauss(random), gauss(random), gauss(random)).normalized());
}

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

/// Points of a plane through the ball's middle that faces view 0, all seen by it alone, `behind`
/// the ball's middle.
void AddWall(Scene& scene, double behind) {
  const Eigen::Vector3d towards = scene.views[0].Center().normalized();
  const Eigen::Vector3d across = towards.unitOrthogonal(), up = towards.cross(across);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int k = 0; k < 600; ++k) {
    Add(scene, 1.1 * unit(random) * across + 1.1 * unit(random) * up - behind * towards);
    scene.points.back().views = {0};
  }
}

TEST(FindAttachment, AReliefGoesOnIntoItsWall) {
  const TestRing ring = MakeTestRing();
  Scene relief = SceneWith(ring), free = SceneWith(ring);
  AddWall(relief, 0);  // as far away as what is seen of the figure
  const Attachment on_wall = FindAttachment(relief, ring.truths, false);
  EXPECT_TRUE(on_wall.attached);
  EXPECT_GT(on_wall.share, 0.95);
  AddBall(free, 300);
  AddWall(free, 1.5);
  std::erase_if(free.points, [&](const SparsePoint& point) {
    // The ball hides the wall behind it.
    return point.views.size() == 1 && (point.position - free.views[0].Center())
                                              .normalized()
                                              .cross(free.views[0].Center().normalized())
                                              .norm() < kBallRadius / kRingDistance;
  });
  const Attachment before_wall = FindAttachment(free, ring.truths, false);
  EXPECT_GT(before_wall.pairs, 40);
  EXPECT_FALSE(before_wall.attached);
  EXPECT_LT(before_wall.share, 0.1);
}

}  // namespace keypose::capture::room_evidence_test
