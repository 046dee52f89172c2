#include "core/pictures/render.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/pictures/testing/from_above.h"
#include "core/values/errors.h"

namespace keypose::render_test {

/// The square [-1,1]^2 at height z, facing +z, with UVs that map x to u and y to v.
Mesh Square(double z = 0) {
  Mesh mesh;
  mesh.points.resize(4, 3);
  mesh.points << -1, -1, z, 1, -1, z, 1, 1, z, -1, 1, z;
  mesh.faces.resize(2, 3);
  mesh.faces << 0, 1, 2, 0, 2, 3;
  mesh.uvs.resize(4, 2);
  mesh.uvs << 0, 0, 1, 0, 1, 1, 0, 1;
  mesh.uv_faces = mesh.faces;
  return mesh;
}

TEST(Rasterize, GivesTheDepthAndFaceOfEachPixel) {
  const Mesh mesh = Square(0.5);
  const View view = FromAbove();
  const Raster raster = Rasterize(mesh, RayScene(mesh.points, mesh.faces), view);
  EXPECT_NEAR(*raster.depth.at(20, 20), 3.5, 1e-5);
  EXPECT_EQ(*raster.face.at(24, 24), 0);  // right of the diagonal, below
  EXPECT_EQ(*raster.face.at(14, 14), 1);
  EXPECT_EQ(*raster.face.at(1, 1), -1);
  EXPECT_TRUE(std::isinf(*raster.depth.at(1, 1)));
  int covered = 0;
  for (const int f : raster.face.data) covered += f >= 0;
  EXPECT_NEAR(covered, std::pow(2 / 3.5 * 40, 2),
              2 * 24);  // the square's edge may fall either way in one row and column
}

TEST(Rasterize, HonoursDistortion) {
  const Mesh mesh = Square();
  View view = FromAbove(400);
  view.camera.k1 = 0.4;
  const Raster raster = Rasterize(mesh, RayScene(mesh.points, mesh.faces), view);
  const Eigen::Vector2d corner = view.Project({1, 1, 0});
  const auto hit = [&](double dx, double dy) {
    return *raster.face.at(static_cast<int>(corner.x() + dx), static_cast<int>(corner.y() + dy)) >=
           0;
  };
  EXPECT_TRUE(hit(-3, 3));
  EXPECT_FALSE(hit(3, -3));
  EXPECT_GT(corner.x(), 303);  // pinhole would say 300
}

TEST(Render, UnlitTextureArrivesUnchangedAndTheRightWayUp) {
  const Mesh mesh = Square();
  Image8 texture(2, 2, 3);
  const std::uint8_t colors[4][3] = {
      {250, 10, 20},
      {30, 240, 50},
      {60, 70, 230},
      {200, 200, 40}};  // top left, top right, bottom left, bottom right
  for (int i = 0; i < 4; ++i) std::copy(colors[i], colors[i] + 3, texture.at(i % 2, i / 2));
  RenderOptions options;
  options.texture = &texture;
  options.shading = 0;
  const Image8 image = Render(mesh, FromAbove(), options);
  const int at[4][2] = {{11, 11}, {28, 11}, {11, 28}, {28, 28}};
  for (int i = 0; i < 4; ++i)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(image.at(at[i][0], at[i][1])[c], colors[i][c], 1) << i << " " << c;
  EXPECT_EQ(image.at(0, 0)[0], options.background[0]);
}

TEST(Render, FaceColorsWinOverVertexColorsAndTheMeshsOwn) {
  Mesh mesh = Square();
  mesh.colors = ColorsX3::Constant(4, 3, 10);
  RenderOptions options;
  options.shading = 0;
  EXPECT_EQ(Render(mesh, FromAbove(), options).at(20, 20)[0], 10);
  options.vertex_colors = ColorsX3::Constant(4, 3, 90);
  EXPECT_EQ(Render(mesh, FromAbove(), options).at(20, 20)[0], 90);
  options.face_colors = ColorsX3::Constant(2, 3, 170);
  EXPECT_EQ(Render(mesh, FromAbove(), options).at(20, 20)[0], 170);
  options.face_colors = ColorsX3::Constant(3, 3, 170);
  EXPECT_THROW(Render(mesh, FromAbove(), options), InputError);
}

TEST(Render, ShadingDarkensWhatTurnsAwayFromTheLamps) {
  Mesh tilted = Square();
  tilted.points.col(2) = -1.5 * tilted.points.col(1);  // faces up in the picture
  Mesh other = Square();
  other.points.col(2) = 1.5 * other.points.col(1);
  RenderOptions options;
  options.smooth = false;
  EXPECT_GT(Render(other, FromAbove(), options).at(20, 20)[0] + 0, 0);
  EXPECT_GT(std::abs(Render(tilted, FromAbove(), options).at(20, 20)[0] -
                     Render(other, FromAbove(), options).at(20, 20)[0]),
            20);
}

TEST(Render, SameBitsAtOneAndThreeThreads) {
  const Mesh mesh = Square();
  RenderOptions options;
  options.wireframe = true;
  SetThreadCount(1);
  const Image8 one = Render(mesh, FromAbove(), options);
  SetThreadCount(3);
  const Image8 three = Render(mesh, FromAbove(), options);
  SetThreadCount(0);
  EXPECT_EQ(one.data, three.data);
}

/// Length of [begin, end] within the pixel that starts at x.
double Overlap(double begin, double end, int x) {
  return std::max(0.0, std::min(end, x + 1.0) - std::max<double>(begin, x));
}

TEST(RenderCutout, AlphaIsTheShareOfThePixelThatARectangleCovers) {
  Mesh mesh = Square();
  const double left = 10.3, right = 29.65, top = 8.45,
               bottom = 31.9;  // pixels, of 10 units a pixel
  mesh.points.col(0) =
      mesh.points.col(0).unaryExpr([&](double x) { return ((x < 0 ? left : right) - 20) / 10; });
  mesh.points.col(1) =
      mesh.points.col(1).unaryExpr([&](double y) { return (20 - (y < 0 ? bottom : top)) / 10; });
  const RayScene scene(mesh.points, mesh.faces);
  const Image8 image = RenderCutout(mesh, scene, FromAbove());
  ASSERT_EQ(image.channels, 4);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) {
      const double across = Overlap(left, right, x), down = Overlap(top, bottom, y);
      const double covered = across * down;
      // 32 rays: at an edge, half a step and the rounding to 8 bits; at a corner a step and a half.
      const bool corner = across > 0 && across < 1 && down > 0 && down < 1;
      EXPECT_NEAR(image.at(x, y)[3] / 255.0, covered, corner ? 1.5 / 32 : 0.5 / 32 + 0.5 / 255)
          << x << " " << y;
      const int sum = image.at(x, y)[0] + image.at(x, y)[1] + image.at(x, y)[2];
      EXPECT_EQ(sum == 0, covered == 0);
    }
}

TEST(RenderCutout, ColourIsNotDarkenedWhereThePixelIsPartlyCovered) {
  Mesh mesh = Square();
  mesh.points *= 0.97;
  mesh.colors = ColorsX3::Constant(4, 3, 180);
  RenderOptions options;
  options.shading = 0;
  const Image8 image = RenderCutout(mesh, RayScene(mesh.points, mesh.faces), FromAbove(), options);
  int partly = 0;
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) {
      if (image.at(x, y)[3] == 0) continue;
      partly += image.at(x, y)[3] < 255;
      EXPECT_EQ(image.at(x, y)[0], 180) << x << " " << y;
    }
  EXPECT_GT(partly, 70) << "the border of 20 x 20 pixels";
}

/// A bright square in front of a dark one, one inside the other in the picture.
Mesh SquareBeforeSquare() {
  const Mesh front = Square(), back = Square();
  Mesh both;
  both.points.resize(8, 3);
  both.points << 0.313 * front.points, back.points;
  both.points.topRows(4).col(2).setConstant(2);
  both.faces.resize(4, 3);
  both.faces << front.faces, back.faces.array() + 4;
  both.colors = ColorsX3::Constant(8, 3, 250);
  both.colors.bottomRows(4).setConstant(0);
  return both;
}

TEST(RenderCutout, OutlinesInsideTheFigureAreAsSmoothAsItsBorder) {
  const Mesh mesh = SquareBeforeSquare();
  const RayScene scene(mesh.points, mesh.faces);
  RenderOptions options;
  options.shading = 0;
  options.samples = 1;
  const Image8 image = RenderCutout(mesh, scene, FromAbove(), options);
  const double edge = 20 - 0.313 * 40 / 2;  // of the bright square, from the left
  const int x = static_cast<int>(edge);
  const double light = x + 1 - edge;
  EXPECT_EQ(image.at(x, 20)[3], 255);
  EXPECT_NEAR(std::pow(image.at(x, 20)[0] / 250.0, 2.2), light, 0.05);
  EXPECT_EQ(image.at(x - 1, 20)[0], 0);
  EXPECT_EQ(image.at(x + 1, 20)[0], 250);
}

TEST(RenderCutout, OverABackgroundItIsWhatRenderShows) {
  const Mesh mesh = Square();
  const RayScene scene(mesh.points, mesh.faces);
  const Image8 cutout = RenderCutout(mesh, scene, FromAbove()),
               whole = Render(mesh, scene, FromAbove());
  for (int y = 12; y < 28; ++y)
    for (int x = 12; x < 28; ++x)
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(cutout.at(x, y)[k], whole.at(x, y)[k], 1);
  EXPECT_EQ(cutout.at(0, 0)[3], 0);
}

TEST(RenderCutout, SameBitsAtOneAndThreeThreads) {
  const Mesh mesh = SquareBeforeSquare();
  const RayScene scene(mesh.points, mesh.faces);
  SetThreadCount(1);
  const Image8 one = RenderCutout(mesh, scene, FromAbove());
  SetThreadCount(3);
  const Image8 three = RenderCutout(mesh, scene, FromAbove());
  SetThreadCount(0);
  EXPECT_EQ(one.data, three.data);
}

TEST(RenderCutout, WrongNumberOfColoursThrowsInputError) {
  const Mesh mesh = Square();
  RenderOptions options;
  options.face_colors = ColorsX3::Constant(3, 3, 170);
  EXPECT_THROW(RenderCutout(mesh, RayScene(mesh.points, mesh.faces), FromAbove(), options),
               InputError);
}

// Bytes go through linear light and back without a change, over the whole range.
TEST(Render, EveryGreyLevelArrivesUnchanged) {
  Mesh mesh = Square();
  RenderOptions options;
  options.shading = 0;
  options.samples = 1;
  const RayScene scene(mesh.points, mesh.faces);
  for (int grey = 0; grey < 256; ++grey) {
    options.face_colors = ColorsX3::Constant(2, 3, static_cast<std::uint8_t>(grey));
    EXPECT_EQ(Render(mesh, scene, FromAbove(8), options).at(4, 4)[1], grey);
    options.face_colors.resize(0, 3);
    options.vertex_colors = ColorsX3::Constant(4, 3, static_cast<std::uint8_t>(grey));
    EXPECT_EQ(Render(mesh, scene, FromAbove(8), options).at(4, 4)[1], grey);
    options.vertex_colors.resize(0, 3);
  }
}

TEST(MapColor, RunsFromEndToEndAndMarksNaN) {
  EXPECT_EQ(MapColor(-3), MapColor(0));
  EXPECT_EQ(MapColor(7), MapColor(1));
  EXPECT_NE(MapColor(0), MapColor(1));
  EXPECT_EQ(MapColor(std::nan(""))[0], MapColor(std::nan(""))[2]);
  EXPECT_EQ(MapColor(0.5, ColorMap::kDiverging),
            (Eigen::Matrix<std::uint8_t, 3, 1>(242, 242, 242)));
}

}  // namespace keypose::render_test
