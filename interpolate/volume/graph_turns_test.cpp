#include "interpolate/volume/graph_turns.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <array>
#include <cmath>
#include <vector>

#include "core/numbers/rotations.h"
#include "interpolate/testing/bars.h"
#include "interpolate/volume/tet_maps.h"

namespace keypose::interpolation::graph_turns_test {

TEST(LiftTurns, AChainThatCoilsNearlyThreeTimesIsOneLongTurn) {
  std::vector<Eigen::Matrix3d> rotations;
  std::vector<std::array<int, 4>> neighbours;
  const int count = 101;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d wobble(0.03 * std::sin(7.0 * i), 0.03 * std::cos(5.0 * i), 0);
    rotations.push_back(Turn(i * 10 * kPi / 180, Eigen::Vector3d::UnitZ()) * ExpOf(wobble));
    neighbours.push_back({i > 0 ? i - 1 : -1, i + 1 < count ? i + 1 : -1, -1, -1});
  }
  const LiftedTurns lifted = LiftTurns(rotations, 0, neighbours, std::vector<char>(count, 0));
  for (int i = 0; i < count; ++i) {
    EXPECT_NEAR(lifted.turns[i].norm(), i * 10 * kPi / 180, 0.1) << i;
    EXPECT_LT((ExpOf(lifted.turns[i]) * ExpOf(lifted.remainders[i]) - rotations[i]).norm(), 1e-12);
    EXPECT_LT(lifted.remainders[i].norm(), 0.2);
  }
  EXPECT_LT(lifted.largest_tear, 1);
}

TEST(LiftTurns, ARingThatTurnedInsideItselfIsReportedAsTorn) {
  std::vector<Eigen::Matrix3d> rotations;
  std::vector<std::array<int, 4>> neighbours;
  for (int i = 0; i < 36; ++i) {
    rotations.push_back(Turn(i * 10 * kPi / 180, Eigen::Vector3d::UnitX()));
    neighbours.push_back({(i + 35) % 36, (i + 1) % 36, -1, -1});
  }
  EXPECT_NEAR(LiftTurns(rotations, 0, neighbours, std::vector<char>(36, 0)).largest_tear, 2 * kPi,
              0.5);
}

}  // namespace keypose::interpolation::graph_turns_test
