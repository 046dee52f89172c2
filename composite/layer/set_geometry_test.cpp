#include "composite/layer/set_geometry.h"

#include <gtest/gtest.h>

#include "composite/layer/table_shadow.h"
#include "core/surfaces/shapes.h"

namespace keypose::composite::set_geometry_test {

Ground TableOf(const Mesh& figure) { return GroundUnder({figure}, Eigen::Vector3d::UnitZ()); }

/// A level square at a height.
Mesh Shelf(double height) {
  Mesh shelf;
  shelf.points.resize(4, 3), shelf.faces.resize(2, 3);
  shelf.points << -9, -9, height, 9, -9, height, 9, 9, height, -9, 9, height;
  shelf.faces << 0, 1, 2, 0, 2, 3;
  return shelf;
}

TEST(SetShadow, ALevelShelfLosesWhatATableWould) {
  Mesh ball = MakeIcosphere(3);
  ball.points.col(2).array() += 1;
  const RayScene scene(ball.points, ball.faces);
  const Ground table = TableOf(ball);
  for (const ShadowStrength& strength :
       {ShadowStrength{0, 0.6, {Eigen::Vector3d(1, 0, 1).normalized(), 0.05}},
        ShadowStrength{0.3, 0.6, {Eigen::Vector3d(1, 0, 1).normalized(), 0.05}}}) {
    const SetGeometry level(Shelf(0));
    const SetShadow on_set(scene, level, table, strength);
    const TableShadow on_table(scene, table, strength);
    for (const Eigen::Vector3d& place :
         {Eigen::Vector3d(-1, 0.05, 0), {-1.8, 0.1, 0}, {1.5, 0.2, 0}, {0.3, -1.2, 0}})
      EXPECT_NEAR(on_set.Kept(place, 0, {0, -5, 5}), on_table.Kept(place), 0.06)
          << place.transpose();
  }
}

TEST(SetShadow, FallsOnUprightFacesAndNotTwice) {
  Mesh ball = MakeIcosphere(3);
  ball.points.col(2).array() += 1;
  const RayScene scene(ball.points, ball.faces);
  const Ground table = TableOf(ball);
  const ShadowStrength strength{0, 0.6, {Eigen::Vector3d(1, 0, 0.6).normalized(), 0.05}};
  Mesh wall = Shelf(0);  // upright at x = -2
  wall.points.col(2) = wall.points.col(0);
  wall.points.col(0).setConstant(-2);
  const SetGeometry set(wall);
  const SetShadow shadow(scene, set, table, strength);
  // The lamp's line through the ball's middle meets the wall at z = 1 - 0.6 * 2.
  EXPECT_LT(shadow.Kept({-2, 0, -0.2}, 0, {5, -5, 5}), 0.4) << "steeper to the lamp than the table";
  EXPECT_EQ(shadow.Kept({-2, 4, -0.2}, 0, {5, -5, 5}), 1) << "beside it";
  EXPECT_EQ(shadow.Kept({-2, 0, -0.2}, 0, {-5, 0, 1}), 1) << "the wall's back sees no lamp";
  Mesh roof = Shelf(4);  // keeps the lamp from everything
  Mesh both = wall;
  both.points.conservativeResize(8, 3), both.faces.conservativeResize(4, 3);
  both.points.bottomRows(4) = roof.points, both.faces.bottomRows(2) = roof.faces.array() + 4;
  const SetGeometry dark(both);
  EXPECT_EQ(SetShadow(scene, dark, table, strength).Kept({-2, 0, -0.2}, 0, {5, -5, 5}), 1)
      << "where the set's own shadow is, none is lost";
  EXPECT_EQ(shadow.Kept({-2, 80, 0}, 0, {5, -5, 5}), 1) << "far away";
}

}  // namespace keypose::composite::set_geometry_test
