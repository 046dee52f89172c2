#include "core/surfaces/surface_distance.h"

#include <gtest/gtest.h>

#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"

namespace keypose::surface_distance_test {

/// A unit square at a height.
Mesh SquareAt(double z) {
  Mesh mesh;
  mesh.points.resize(4, 3);
  mesh.points << 0, 0, z, 1, 0, z, 1, 1, z, 0, 1, z;
  mesh.faces.resize(2, 3);
  mesh.faces << 0, 1, 2, 0, 2, 3;
  return mesh;
}

TEST(DistancesTo, OfPointsAboveAndBesideASquare) {
  const Mesh square = SquareAt(0);
  PointsX3 points(3, 3);
  points << 0.5, 0.5, 0.25, 4, 1, 4, 0.5, 0.5, 0;
  const Eigen::VectorXd distances = DistancesTo(RayScene(square.points, square.faces), points);
  EXPECT_EQ(distances[0], 0.25);
  EXPECT_EQ(distances[1], 5);  // from the edge at x = 1
  EXPECT_EQ(distances[2], 0);
}

TEST(SampledDistances, BetweenParallelSquaresAreTheirDistance) {
  const Mesh low = SquareAt(0), high = SquareAt(2);
  const Eigen::VectorXd distances =
      SampledDistances(low, RayScene(high.points, high.faces), 100, 5);
  ASSERT_EQ(distances.size(), 100);
  EXPECT_NEAR(distances.minCoeff(), 2, 1e-12);
  EXPECT_NEAR(distances.maxCoeff(), 2, 1e-12);
}

TEST(SampledDistances, SameBitsForAnyThreadCount) {
  const Mesh fine = MakeIcosphere(3), coarse = MakeIcosphere(1);
  const RayScene scene(coarse.points, coarse.faces);
  SetThreadCount(1);
  const Eigen::VectorXd one = SampledDistances(fine, scene, 2000, 5);
  SetThreadCount(3);
  const Eigen::VectorXd three = SampledDistances(fine, scene, 2000, 5);
  SetThreadCount(0);
  EXPECT_EQ(one, three);
}

}  // namespace keypose::surface_distance_test
