#include "capture/room/free_standing.h"

#include <gtest/gtest.h>

#include <random>

#include "capture/room/testing/scattered_points.h"
#include "capture/testing/test_ring.h"

namespace keypose::capture::free_standing_test {

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

}  // namespace keypose::capture::free_standing_test
