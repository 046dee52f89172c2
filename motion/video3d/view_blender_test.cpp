#include "motion/video3d/view_blender.h"

#include <gtest/gtest.h>

#include "core/numbers/parallel.h"
#include "motion/testing/filmed_ball.h"
#include "motion/video3d/testing/seen_ball.h"

namespace keypose::motion::view_blender_test {

using Eigen::Vector3f;

TEST_F(Ball, OneCameraThatContradictsTheOthersIsOutvoted) {
  world = BallWorld(10);
  even.assign(10, Vector3f::Ones());
  ViewBlender agreeing(world.mesh.faces, texels, 10, {0, true}),
      trusting(world.mesh.faces, texels, 10, {0, false}), clean(world.mesh.faces, texels, 10, {});
  const PointsX3 points = world.Points(0);
  const TexelColors truth = clean.Next(points, Views(0), even);
  const std::vector<FilmedView> views = Views(0, 2);
  const double with = Difference(agreeing.Next(points, views, even), truth),
               without = Difference(trusting.Next(points, views, even), truth);
  EXPECT_GT(without, 20);
  EXPECT_LT(with, 0.5 * without);
}

TEST_F(Ball, SameBitsForAnyThreadCount) {
  const PointsX3 points = world.Points(0);
  const std::vector<FilmedView> views = Views(0);
  SetThreadCount(1);
  ViewBlender one(world.mesh.faces, texels, 6, {});
  const TexelColors first = one.Next(points, views, even);
  SetThreadCount(3);
  ViewBlender many(world.mesh.faces, texels, 6, {});
  EXPECT_EQ(many.Next(points, views, even).color, first.color);
  SetThreadCount(0);
}

}  // namespace keypose::motion::view_blender_test
