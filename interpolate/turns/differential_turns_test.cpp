#include "interpolate/turns/differential_turns.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "core/surfaces/shapes.h"
#include "interpolate/turns/testing/twisted_bar.h"
#include "interpolate/turns/turns.h"

namespace keypose::interpolation::differential_turns_test {

TEST(DifferentialTurns, GivesTheSameWayWhereBothServe) {
  const Mesh mesh = MakeCylinder(0.08, kLength, 12, 60);
  const PointsX3 end = Twisted(mesh.points, 400);
  const PoissonSystem system({mesh.points, end}, mesh.faces);
  SegmentMaps maps = FaceMapsOf(mesh.points, end, mesh.faces);
  FollowTurns(system, maps);
  const DifferentialTurns differential(system, maps);
  double worst = 0;
  const std::vector<Eigen::Matrix3d> half = differential.At(0.5), whole = differential.At(1);
  const Eigen::Matrix3d body = ExpOf(maps.body_turn);
  for (std::size_t f = 0; f < half.size(); ++f) {
    EXPECT_LT((body * whole[f] - maps.faces[f].rotation).norm(), 1e-9);
    worst = std::max(
        worst,
        (half[f] - ExpOf(0.5 * maps.faces[f].turn) * ExpOf(0.5 * maps.faces[f].remainder)).norm());
  }
  EXPECT_LT(worst, 0.15);
}

}  // namespace keypose::interpolation::differential_turns_test
