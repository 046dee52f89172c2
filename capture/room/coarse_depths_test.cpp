#include "capture/room/coarse_depths.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/room/testing/figure_on_book.h"
#include "core/numbers/parallel.h"

namespace keypose::capture::coarse_depths_test {

using Eigen::Vector3d;

TEST_F(StandingFigureTest, DepthsAreThoseOfTheScene) {
  int all = 0, right = 0;
  for (std::size_t v = 0; v < Depths().views.size(); ++v)
    for (const DepthSample& sample : Depths().views[v]) {
      const Vector3d from = World().scene.views[v].Center(), ray = sample.point - from;
      ++all;
      right += std::abs(Look(from, ray).t - 1) < 0.02;
    }
  EXPECT_GT(all, 100000);
  EXPECT_GT(right, 0.98 * all);
}

TEST_F(StandingFigureTest, SameForAnyThreadCount) {
  Depths();
  SetThreadCount(1);
  const CoarseDepths one = FindCoarseDepths(World().images, World().scene, World().middle);
  SetThreadCount(0);
  for (std::size_t v = 0; v < one.views.size(); ++v) {
    ASSERT_EQ(one.views[v].size(), Depths().views[v].size());
    for (std::size_t k = 0; k < one.views[v].size(); ++k)
      ASSERT_EQ(one.views[v][k].point, Depths().views[v][k].point);
  }
}

}  // namespace keypose::capture::coarse_depths_test
