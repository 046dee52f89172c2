#include "composite/layer/character_layer.h"

#include <gtest/gtest.h>

namespace keypose::composite::character_layer_test {

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

}  // namespace keypose::composite::character_layer_test
