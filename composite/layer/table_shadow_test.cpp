#include "composite/layer/table_shadow.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/surfaces/shapes.h"

namespace keypose::composite::table_shadow_test {

Ground TableOf(const Mesh& figure) { return GroundUnder({figure}, Eigen::Vector3d::UnitZ()); }

TEST(TableShadow, FallsAwayFromTheLamp) {
  Mesh ball = MakeIcosphere(3);
  ball.points.col(2).array() += 1;  // stands on the table
  const RayScene scene(ball.points, ball.faces);
  ShadowStrength strength{0, 0.8, {Eigen::Vector3d(1, 0, 1).normalized(), 0.05}};
  const TableShadow shadow(scene, TableOf(ball), strength);
  EXPECT_NEAR(shadow.Kept({-1, 0, 0}), 0.2, 0.02) << "below the line through the ball's middle";
  EXPECT_EQ(shadow.Kept({1.5, 0, 0}), 1) << "on the lamp's side";
  EXPECT_EQ(shadow.Kept({50, 50, 0}), 1) << "far away";
}

TEST(TableShadow, ALowLampsShadowIsAsLongAsItIs) {
  // A post of a tenth by a tenth, one high.
  Mesh post = MakeBox(0.1, 0.1, 1);
  post.points.leftCols(2).array() -= 0.05;
  const RayScene scene(post.points, post.faces);
  for (const double degrees : {12.0, 20.0, 35.0, 60.0}) {
    const double height = degrees * M_PI / 180, end = 1 / std::tan(height);
    const TableShadow shadow(
        scene, TableOf(post),
        {0, 0.8, {Eigen::Vector3d(std::cos(height), 0, std::sin(height)), 0.01}});
    for (const double share : {0.3, 0.6, 0.9})
      EXPECT_NEAR(shadow.Kept({-share * end, 0, 0}), 0.2, 0.15) << degrees << " " << share;
    EXPECT_EQ(shadow.Kept({-1.2 * end - 0.1, 0, 0}), 1) << degrees;
    EXPECT_EQ(shadow.Kept({-0.5 * end, 0.3, 0}), 1) << degrees;
  }
}

TEST(TableShadow, TheSkyMakesAContactShadow) {
  Mesh ball = MakeIcosphere(3);
  ball.points.col(2).array() += 1;
  const RayScene scene(ball.points, ball.faces);
  const TableShadow shadow(scene, TableOf(ball), {1, 0, {}});
  EXPECT_LT(shadow.Kept({0.05, 0, 0}), 0.1);
  EXPECT_GT(shadow.Kept({1.5, 0, 0}), shadow.Kept({0.7, 0, 0}));
  EXPECT_EQ(TableShadow(scene, TableOf(ball), {}).Kept({0.05, 0, 0}), 1);
}

}  // namespace keypose::composite::table_shadow_test
