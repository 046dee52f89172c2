#include "texture/charts/hidden_seams.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"
#include "texture/testing/snowman.h"

namespace keypose::texture::hidden_seams_test {

int Nearest(const Surface& s, const Eigen::RowVector3d& p) {
  Eigen::Index at = 0;
  (s.points.rowwise() - p).rowwise().squaredNorm().minCoeff(&at);
  return static_cast<int>(at);
}

TEST(FindExposure, FrontOfABallIsSeenMoreThanItsBackAndThatMoreThanBelow) {
  const Surface s = MakeSurface(MakeIcosphere(4));
  const Exposure exposure = FindExposure(s, {});
  const double front = exposure.seen[Nearest(s, {0, -1, 0})],
               back = exposure.seen[Nearest(s, {0, 1, 0})],
               below = exposure.seen[Nearest(s, {0, 0, -1})];
  EXPECT_GT(front, 1.5 * back);
  EXPECT_GT(back, 1.5 * below);
  EXPECT_TRUE(exposure.front[Nearest(s, {0, -1, 0})]);
  EXPECT_FALSE(exposure.front[Nearest(s, {1, 0, 0})]);
  EXPECT_FALSE(exposure.front[Nearest(s, {0, 1, 0})]);
  EXPECT_GE(exposure.seen.minCoeff(), 0);
  EXPECT_LE(exposure.seen.maxCoeff(), 1);
  EXPECT_GT(exposure.cost.minCoeff(), 0);
}

TEST(FindExposure, TurnedFigureWithTurnedViewersLooksTheSame) {
  Mesh ball = Snowman(3);
  const Exposure upright = FindExposure(MakeSurface(ball), {});
  Mesh lying = ball;  // x to y to z to x: exact
  lying.points.col(0) = ball.points.col(2);
  lying.points.col(1) = ball.points.col(0);
  lying.points.col(2) = ball.points.col(1);
  const Exposure turned = FindExposure(MakeSurface(lying), {.up = {1, 0, 0}, .front = {0, 0, -1}});
  // Grazing rays may fall on either side.
  EXPECT_LT((upright.seen - turned.seen).cwiseAbs().mean(), 2e-3);
}

TEST(FindExposure, SeamsAreCheapInACrease) {
  const Surface s = MakeSurface(Snowman(5));
  const Exposure exposure = FindExposure(s, {});
  const double waist = exposure.cost[Nearest(s, {0, -0.4, 0})],
               belly = exposure.cost[Nearest(s, {0, -0.85, -0.9})];
  EXPECT_LT(waist, 0.35 * belly);
}

TEST(FindExposure, SameBitsForAnyThreadCount) {
  const Surface s = MakeSurface(Snowman(3));
  SetThreadCount(1);
  const Exposure one = FindExposure(s, {});
  SetThreadCount(2);
  const Exposure two = FindExposure(s, {});
  SetThreadCount(0);
  EXPECT_EQ(one.seen, two.seen);
  EXPECT_EQ(one.cost, two.cost);
}

TEST(BetterBorder, MovesFromATiltedCircleToACheapRing) {
  const Surface s = MakeSurface(MakeIcosphere(4));
  // Cheap along the equator, which is a line of edges in this ball.
  Eigen::VectorXd cost(s.points.rows());
  for (Eigen::Index v = 0; v < cost.size(); ++v)
    cost[v] = std::abs(s.points(v, 2)) < 1e-9 ? 0.01 : 1;
  const PointsX3 costs = SeamCosts(s, cost);
  std::vector<int> label(s.faces.rows());
  for (int f = 0; f < std::ssize(label); ++f)
    label[f] = s.centers(f, 2) + 0.15 * s.centers(f, 0) > 0.02 ? 3 : 7;
  const std::vector<int> changed = BetterBorder(s, costs, label, 3, 7, 12);
  EXPECT_FALSE(changed.empty());
  for (const int f : changed) label[f] = 10 - label[f];
  for (int f = 0; f < std::ssize(label); ++f) EXPECT_EQ(label[f], s.centers(f, 2) > 0 ? 3 : 7) << f;
  EXPECT_TRUE(BetterBorder(s, costs, label, 3, 7, 12).empty());  // the best stays
}

}  // namespace keypose::texture::hidden_seams_test
