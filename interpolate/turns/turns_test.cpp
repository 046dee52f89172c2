#include "interpolate/turns/turns.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "core/surfaces/shapes.h"
#include "interpolate/turns/testing/twisted_bar.h"

namespace keypose::interpolation::turns_test {

TEST(FollowTurns, KeepsEveryRotationToAThousandDegrees) {
  const Mesh mesh = MakeCylinder(0.08, kLength, 12, 60);
  const PointsX3 end = Twisted(mesh.points, 1000);
  const PoissonSystem system({mesh.points, end}, mesh.faces);
  SegmentMaps maps = FaceMapsOf(mesh.points, end, mesh.faces);
  const TurnReport report = FollowTurns(system, maps);
  EXPECT_FALSE(report.differential);
  EXPECT_EQ(report.torn_edges, 0);
  // Any region whose rotation is a whole number of turns may be the body; from end to end the tube
  // turns by the full angle.
  double least = 0, most = 0;
  for (const FaceMap& map : maps.faces)
    least = std::min(least, map.turn[2]), most = std::max(most, map.turn[2]);
  EXPECT_NEAR(most - least, 1000 * kPi / 180, 1000 * kPi / 180 / 60);  // a ring of faces
  const Eigen::Matrix3d body = ExpOf(maps.body_turn);
  for (const FaceMap& map : maps.faces)
    EXPECT_LT((body * ExpOf(map.turn) * ExpOf(map.remainder) - map.rotation).norm(), 1e-9);
}

TEST(FollowTurns, RemaindersLieAcrossTheTurns) {
  const Mesh mesh = MakeCylinder(0.12, kLength, 12, 40);
  const PointsX3 end = Twisted(mesh.points, 300);
  const PoissonSystem system({mesh.points, end}, mesh.faces);
  SegmentMaps maps = FaceMapsOf(mesh.points, end, mesh.faces);
  FollowTurns(system, maps);
  for (const FaceMap& map : maps.faces)
    if (map.turn.norm() > 0.5) {
      EXPECT_LT(std::abs(map.turn.normalized().dot(map.remainder)), 1e-9);
    }
}

TEST(FollowTurns, BodyIsWhatMostFacesTurnWith) {
  // Two thirds of the tube turn rigidly by 70 degrees; the rest twists by 200 more.
  const Mesh mesh = MakeCylinder(0.12, kLength, 12, 40);
  const Eigen::Vector3d turn = 70 * kPi / 180 * Eigen::Vector3d(1, 2, 2) / 3;
  const PointsX3 end = Twisted(mesh.points, 200, 1.3) * ExpOf(turn).transpose();
  const PoissonSystem system({mesh.points, end}, mesh.faces);
  SegmentMaps maps = FaceMapsOf(mesh.points, end, mesh.faces);
  FollowTurns(system, maps);
  EXPECT_LT((maps.body_turn - turn).norm(), 0.02);
}

}  // namespace keypose::interpolation::turns_test
