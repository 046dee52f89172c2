#include "armature/live/plate_view.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/pictures/fit_view.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::armature::plate_view_test {

using Eigen::Vector3d;

TEST(DrawPuppet, PuppetCoversThePlateAndTheSetIsGlass) {
  const Mesh ball = MakeIcosphere(3);
  Mesh wall = MakeBox(4, 0.1, 4);
  wall.points.rowwise() += Eigen::RowVector3d(0, -2, -2);  // before the right half of the ball
  const Image8 none;
  PlateView where;
  where.view = FitView(PointsX3(3 * ball.points), 0, 1, 96, 96);
  where.plate = Image8(96, 96, 3, 40);
  const Mesh nothing;
  const Image8 alone = DrawPuppet({ball, none, nothing}, where, ball.points, {});
  EXPECT_EQ(alone.at(3, 3)[0], 40);
  EXPECT_GT(alone.at(48, 48)[0], 80);
  const Image8 with_set = DrawPuppet({ball, none, wall}, where, ball.points, {});
  EXPECT_EQ(with_set.at(40, 48)[0], alone.at(40, 48)[0]);  // left of the wall
  EXPECT_NE(with_set.at(90, 48)[0], 40);                   // the wall over the plate
  EXPECT_NE(with_set.at(56, 48)[0], alone.at(56, 48)[0]);  // the ball behind the wall
  PointsX3 before = ball.points;
  before.col(0).array() -= 1.6;
  const Image8 ghost = DrawPuppet({ball, none, nothing}, where, ball.points, {&before});
  int changed = 0;
  for (std::size_t i = 0; i < ghost.data.size(); ++i) changed += ghost.data[i] != alone.data[i];
  EXPECT_GT(changed, 300);
  where.plate = Image8(64, 96, 3, 40);
  EXPECT_THROW(DrawPuppet({ball, none, nothing}, where, ball.points, {}), InputError);
}

TEST(DrawPuppet, CharacterIsPlacedInTheWorld) {
  const Mesh ball = MakeIcosphere(2);
  const Image8 none;
  const Mesh nothing;
  PlateView where;
  where.view = FitView(PointsX3(3 * ball.points), 0, 1, 64, 64);
  where.world_from_character.scale = 0.1;
  where.world_from_character.translation = Vector3d(2, 0, 0);
  const Image8 picture = DrawPuppet({ball, none, nothing}, where, ball.points, {});
  const Image8 empty =
      DrawPuppet({ball, none, nothing}, where, PointsX3(ball.points.array() + 1e3), {});
  EXPECT_EQ(picture.at(32, 32)[0], empty.at(32, 32)[0]);
  EXPECT_NE(picture.data, empty.data);
}

}  // namespace keypose::armature::plate_view_test
