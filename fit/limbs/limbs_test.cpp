// A bottle with an arm and a hand, whose hand is turned: limbs, their joints, and the search.
#include "fit/limbs/limbs.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/surfaces/shapes.h"
#include "fit/limbs/testing/bottle.h"

namespace keypose::fit::limbs_test {

TEST(FindLimbs, AnArmEndsWhereTheBodyBegins) {
  const Mesh mesh = MakeBottle();
  const Limb arm = ArmOf(mesh);
  double lowest = kTop;
  for (const int v : arm.vertices) lowest = std::min(lowest, mesh.points(v, 2));
  EXPECT_GT(lowest, kNeck - 0.25);
  EXPECT_LT(lowest, kNeck + 0.4);
  EXPECT_TRUE(std::is_sorted(arm.vertices.begin(), arm.vertices.end()));
  int missing = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    missing += mesh.points(v, 2) > kNeck + 0.5 &&
               !std::binary_search(arm.vertices.begin(), arm.vertices.end(), v);
  EXPECT_EQ(missing, 0);
  EXPECT_DOUBLE_EQ(arm.along.minCoeff(), 0);
  EXPECT_DOUBLE_EQ(arm.along.maxCoeff(), arm.length);
}

TEST(FindLimbs, ABallHasNone) {
  const Mesh ball = MakeIcosphere(4);
  EXPECT_TRUE(FindLimbs(ball.points, ball.faces).empty());
}

}  // namespace keypose::fit::limbs_test
