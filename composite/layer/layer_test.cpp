#include <gtest/gtest.h>

#include <cmath>

#include "composite/layer/character_layer.h"
#include "composite/layer/linear_light.h"
#include "composite/layer/set_geometry.h"
#include "composite/layer/table_shadow.h"
#include "core/surfaces/shapes.h"

namespace keypose::composite::layer_test {

/// A square with a texture of one colour, across the view at this depth.
Character Square(PointsX3* points, double left, double top, double right, double bottom,
                 const Camera& camera, double depth) {
  Character square;
  square.faces.resize(2, 3), square.faces << 0, 2, 1, 0, 3, 2;
  square.uv_faces = square.faces;
  square.uvs.resize(4, 2), square.uvs << 0, 1, 1, 1, 1, 0, 0, 0;
  square.texture = ImageF(4, 4, 3, 0.25f);
  points->resize(4, 3);
  const double pixels[4][2] = {{left, top}, {right, top}, {right, bottom}, {left, bottom}};
  for (int i = 0; i < 4; ++i)
    points->row(i) = (depth * camera.Unproject({pixels[i][0], pixels[i][1]})).transpose();
  return square;
}

TEST(CharacterLayer, CoverageIsTheShareOfAPixel) {
  const View view{"", {40, 30, 50, 50, 20, 15}, {}};
  PointsX3 points;
  const Character square = Square(&points, 10.25, 5, 20, 12.5, view.camera, 2);
  const RayScene scene(points, square.faces);
  const PixelRays rays(view.camera);
  const ImageF layer = RenderLayer(square, points, scene, {}, view, rays, 8);
  EXPECT_FLOAT_EQ(layer.at(15, 8)[3], 1);
  EXPECT_FLOAT_EQ(layer.at(15, 8)[0], 0.25f);
  EXPECT_NEAR(layer.at(10, 8)[3], 0.75, 1e-6);
  EXPECT_NEAR(layer.at(15, 12)[3], 0.5, 1e-6);
  EXPECT_NEAR(layer.at(15, 12)[1], 0.125, 1e-6) << "colour is premultiplied";
  EXPECT_EQ(layer.at(9, 8)[3], 0);
  EXPECT_EQ(layer.at(20, 8)[3], 0);
}

TEST(CharacterLayer, EdgesLieWhereTheDistortedCameraHasThem) {
  View view{"", {200, 120, 180, 181, 101.5, 58}, {}};
  view.camera.k1 = -0.15, view.camera.k2 = 0.03, view.camera.p1 = 1e-3, view.camera.p2 = -2e-3;
  PointsX3 points;
  const Character square = Square(&points, 150.5, 20, 190, 100, view.camera, 1);
  const ImageF layer = RenderLayer(square, points, RayScene(points, square.faces), {}, view,
                                   PixelRays(view.camera), 8);
  // The corner is exact; the edge between bends a little.
  const Eigen::Vector2d middle =
      view.camera.Project(0.5 * (points.row(0) + points.row(3)).transpose());
  double covered = 0;
  for (int x = 140; x < 170; ++x) covered += layer.at(x, static_cast<int>(middle.y()))[3];
  EXPECT_NEAR(170 - covered, middle.x(), 0.1);
}

TEST(CharacterLayer, TheTableHidesWhatLiesBelowIt) {
  // The camera looks along z with y down; the table is the plane y = 0.2, seen from above.
  const View view{"", {40, 30, 50, 50, 20, 15}, {}};
  PointsX3 points;
  const Character square = Square(&points, 10, 5, 30, 29, view.camera, 2);
  Ground table;
  table.up = {0, -1, 0}, table.origin = {0, 0.2, 2};
  const RayScene scene(points, square.faces);
  const ImageF layer =
      RenderLayer(square, points, scene, {}, view, PixelRays(view.camera), 4, &table);
  EXPECT_EQ(layer.at(20, 18)[3], 1) << "y is 0.2 at row 20";
  EXPECT_EQ(layer.at(20, 21)[3], 0);
}

TEST(CharacterLayer, GainsMultiplyTheTexturesLight) {
  const View view{"", {40, 30, 50, 50, 20, 15}, {}};
  PointsX3 points;
  const Character square = Square(&points, 10, 5, 30, 25, view.camera, 2);
  PointsX3 gains(4, 3);
  gains << 1, 2, 0.5, 1, 2, 0.5, 1, 2, 0.5, 1, 2, 0.5;
  const ImageF layer = RenderLayer(square, points, RayScene(points, square.faces), gains, view,
                                   PixelRays(view.camera), 2);
  EXPECT_NEAR(layer.at(20, 15)[0], 0.25, 1e-6);
  EXPECT_NEAR(layer.at(20, 15)[1], 0.5, 1e-6);
  EXPECT_NEAR(layer.at(20, 15)[2], 0.125, 1e-6);
}

TEST(LinearLight, EveryStoredLevelComesBack) {
  Image8 levels(256, 1, 1);
  for (int i = 0; i < 256; ++i) *levels.at(i, 0) = static_cast<std::uint8_t>(i);
  EXPECT_EQ(SrgbOf(LinearOf(levels)).data, levels.data);
}

TEST(LinearLight, BlurKeepsTheSumAndASpotsWidth) {
  ImageF spot(41, 41, 1);
  *spot.at(20, 20) = 100;
  const ImageF blurred = Blurred(spot, 2);
  double sum = 0, spread = 0;
  for (int y = 0; y < 41; ++y)
    for (int x = 0; x < 41; ++x)
      sum += *blurred.at(x, y), spread += *blurred.at(x, y) * (x - 20) * (x - 20);
  EXPECT_NEAR(sum, 100, 1e-3);
  EXPECT_NEAR(std::sqrt(spread / sum), 2, 0.05);
  EXPECT_EQ(Blurred(spot, 0).data, spot.data);
}

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

TEST(CharacterLayer, PropsHideWhatIsBehindThemOnly) {
  const View view{"", {40, 30, 50, 50, 20, 15}, {}};
  PointsX3 points, props;
  const Character square = Square(&points, 10, 5, 30, 25, view.camera, 2);
  const Character prop = Square(&props, 0, 0, 20, 30, view.camera, 1);
  const RayScene scene(points, square.faces), before(props, prop.faces),
      behind(3 * props, prop.faces);
  const auto draw = [&](const RayScene& set) {
    return RenderLayer(square, points, scene, {}, view, PixelRays(view.camera), 2, nullptr, &set);
  };
  EXPECT_EQ(draw(before).at(15, 15)[3], 0);
  EXPECT_EQ(draw(before).at(25, 15)[3], 1);
  EXPECT_EQ(draw(behind).at(15, 15)[3], 1);
}

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

}  // namespace keypose::composite::layer_test
