#include "motion/root/holds.h"

#include <gtest/gtest.h>

#include <cmath>

#include "motion/root/feet.h"

namespace keypose::motion::holds_test {

TEST(HoldRuns, EasesInAndOut) {
  std::vector<char> held(30, 0);
  std::fill(held.begin() + 10, held.begin() + 20, 1);
  const PatchHold hold =
      HoldRuns(PointsX3::Zero(30, 3), held, [](int, int) { return Eigen::RowVector3d(1, 0, 0); });
  EXPECT_EQ(hold.moves.row(0).norm(), 0);
  EXPECT_EQ(hold.moves.row(29).norm(), 0);
  for (int t = 10; t < 20; ++t) EXPECT_EQ(hold.moves(t, 0), 1);
  for (int t = 0; t + 1 < 30; ++t)
    EXPECT_LT(std::abs(hold.moves(t + 1, 0) - hold.moves(t, 0)), 0.35) << t;
}

}  // namespace keypose::motion::holds_test
