#include "synth/worlds/lying.h"

#include <gtest/gtest.h>

#include "synth/worlds/world.h"

namespace keypose::synth::lying_test {

using Eigen::Vector3d;

TEST(LayDown, IsARigidTurnOntoTheBack) {
  WorldOptions options;
  options.spacing_m = 0.006;
  const World world = MakeWorld(options);
  const Pose& bent = world.PoseNamed("bent");
  const PointsX3 standing = bent(world.rest.points);
  const Lying lying = LayDown(bent, standing);
  const PointsX3 points = lying.pose(world.rest.points);
  EXPECT_NEAR(points.col(2).minCoeff(), 0, 1e-12);
  EXPECT_NEAR(points.col(1).minCoeff() + points.col(1).maxCoeff(), 0, 1e-12);
  for (Eigen::Index i = 0; i < standing.rows(); i += 50)
    EXPECT_LT(
        (lying.table_from_character * Vector3d(standing.row(i)) - Vector3d(points.row(i))).norm(),
        1e-12);
  // The soles, which were on the table, now face forwards.
  Eigen::Index sole;
  standing.col(2).minCoeff(&sole);
  EXPECT_LT(points(sole, 1), points.col(1).minCoeff() + 0.002);
}

}  // namespace keypose::synth::lying_test
