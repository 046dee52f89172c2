#include "deform/volume/volume_correction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::volume_correction_test {

TEST(VolumeCorrection, ReachesTheVolumeToRoundingInOneStep) {
  Mesh mesh = MakeCylinder(0.3, 2, 16, 20);
  mesh.points.rowwise() += Eigen::RowVector3d(100, -50, 20);  // far from the origin
  const PoissonSystem system({mesh.points}, mesh.faces);
  const VolumeCorrection correction(system);
  const PointsX3 z = correction.Direction(mesh.points);
  for (double factor : {0.9, 0.999, 1.0, 1.05, 1.3}) {
    PointsX3 points = mesh.points;
    const double target = factor * correction.Volumes(mesh.points)[0];
    const VolumeCorrection::Result result = correction.Apply(points, z, {target});
    EXPECT_NEAR(correction.Volumes(points)[0] / target, 1, 1e-12);
    EXPECT_EQ(result.corrected, 1);
    EXPECT_NEAR(result.largest_move, (points - mesh.points).rowwise().norm().maxCoeff(), 1e-12);
    EXPECT_LT((points - mesh.points).colwise().mean().norm(), 1e-12);  // the centroid stays
  }
}

TEST(VolumeCorrection, SphereGrowsAlongItsNormals) {
  const Mesh mesh = MakeIcosphere(3);
  const PoissonSystem system({mesh.points}, mesh.faces);
  const PointsX3 z = VolumeCorrection(system).Direction(mesh.points);
  for (Eigen::Index i = 0; i < z.rows(); ++i)
    EXPECT_GT(z.row(i).normalized().dot(mesh.points.row(i)), 0.9999);
}

TEST(VolumeCorrection, GainsTheVolumeWithLessStretchThanNormalsDo) {
  // A thin limb on a body: the field hardly changes the limb's radius, unlike normals of unit
  // length.
  const Mesh mesh = MakeCylinder(0.02, 2, 12, 100);
  const PoissonSystem system({mesh.points}, mesh.faces);
  const PointsX3 z = VolumeCorrection(system).Direction(mesh.points);
  EXPECT_LT(z.middleRows(12 * 50, 12).leftCols(2).rowwise().norm().maxCoeff(), 0.2);
}

TEST(VolumeCorrection, OutOfReachIsLeftAloneAndSaid) {
  const Mesh mesh = MakeIcosphere(2);
  const PoissonSystem system({mesh.points}, mesh.faces);
  const VolumeCorrection correction(system);
  PointsX3 points = mesh.points;
  const VolumeCorrection::Result result =
      correction.Apply(points, correction.Direction(points), {1e3});
  EXPECT_EQ(result.unreachable, 1);
  EXPECT_EQ(points, mesh.points);
  EXPECT_EQ(
      correction
          .Apply(points, correction.Direction(points), {std::numeric_limits<double>::quiet_NaN()})
          .corrected,
      0);
}

TEST(PathVolumes, AreGeometricAndLeaveOtherSignsAlone) {
  const std::vector<double> path = PathVolumes({1, -2, 1, 0}, {4, -8, -1, 2}, 0.5);
  EXPECT_DOUBLE_EQ(path[0], 2);
  EXPECT_DOUBLE_EQ(path[1], -4);
  EXPECT_TRUE(std::isnan(path[2]));
  EXPECT_TRUE(std::isnan(path[3]));
}

}  // namespace keypose::volume_correction_test
