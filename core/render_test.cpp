#include "core/render.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/cloud_picture.h"
#include "core/errors.h"
#include "core/parallel.h"

namespace keypose {
namespace {

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

View FromAbove(int size = 40) {
  View view;
  view.camera.width = view.camera.height = size;
  view.camera.fx = view.camera.fy = size;  // at distance 4 the square covers the middle half
  view.camera.cx = view.camera.cy = size / 2.0;
  view.camera_from_world = LookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0});
  return view;
}

TEST(LookAt, TargetIsAheadAndUpIsUpwards) {
  const Eigen::Vector3d eye(3, -2, 1), target(0.5, 0.2, -0.3);
  const Rigid3 camera_from_world = LookAt(eye, target);
  const Eigen::Vector3d ahead = camera_from_world * target;
  EXPECT_NEAR(ahead.x(), 0, 1e-12);
  EXPECT_NEAR(ahead.y(), 0, 1e-12);
  EXPECT_NEAR(ahead.z(), (target - eye).norm(), 1e-12);
  EXPECT_NEAR((camera_from_world * eye).norm(), 0, 1e-12);
  EXPECT_LT((camera_from_world * (target + Eigen::Vector3d(0, 0, 0.1))).y(), 0);  // y is down
  EXPECT_THROW(LookAt(eye, eye), InputError);
}

TEST(FitView, HoldsEveryPointAndFillsThePicture) {
  PointsX3 points(3, 3);
  points << 0, 0, 0, 5, 1, 0, 1, 2, 9;
  for (const double azimuth : {0.0, 77.0, 200.0}) {
    const View view = FitView(points, azimuth, 20, 320, 200);
    double most = 0;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector2d p = view.Project(points.row(i));
      EXPECT_GT(p.minCoeff(), 0);
      EXPECT_LT(p.x(), 320);
      EXPECT_LT(p.y(), 200);
      most = std::max({most, std::abs(p.x() / 160 - 1), std::abs(p.y() / 100 - 1)});
    }
    EXPECT_GT(most, 0.85);
  }
}

TEST(FitView, AzimuthZeroSeesTheFrontAndNinetyTheRight) {
  PointsX3 points(2, 3);
  points << -1, -1, -1, 1, 1, 1;
  EXPECT_LT(FitView(points, 0, 0, 10, 10).Center().y(), -1);
  EXPECT_GT(FitView(points, 90, 0, 10, 10).Center().x(), 1);
  EXPECT_GT(FitView(points, 0, 60, 10, 10).Center().z(), 1);
  EXPECT_THROW(FitView(PointsX3(0, 3), 0, 0, 10, 10), InputError);
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

TEST(MapColor, RunsFromEndToEndAndMarksNaN) {
  EXPECT_EQ(MapColor(-3), MapColor(0));
  EXPECT_EQ(MapColor(7), MapColor(1));
  EXPECT_NE(MapColor(0), MapColor(1));
  EXPECT_EQ(MapColor(std::nan(""))[0], MapColor(std::nan(""))[2]);
  EXPECT_EQ(MapColor(0.5, ColorMap::kDiverging),
            (Eigen::Matrix<std::uint8_t, 3, 1>(242, 242, 242)));
}

TEST(RenderCloud, TheNearestPointIsInFrontInItsOwnColour) {
  PointCloud cloud;
  cloud.points.resize(2, 3);
  cloud.points << 0, 0, 1, 0, 0, 0;  // the view is from above: the first is nearer
  cloud.colors.resize(2, 3);
  cloud.colors << 200, 10, 20, 1, 2, 3;
  const Image8 picture = RenderCloud(cloud, FromAbove());
  EXPECT_EQ(*picture.at(20, 20), 200);
  EXPECT_EQ(*picture.at(5, 5), 247);
}

TEST(TileImages, PlacesImagesInRowsWithGaps) {
  const std::vector<Image8> images = {Image8(4, 2, 3, 10), Image8(4, 2, 1, 20),
                                      Image8(2, 2, 3, 30)};
  const Image8 sheet = TileImages(images, 2, 1);
  EXPECT_EQ(sheet.width, 9);
  EXPECT_EQ(sheet.height, 5);
  EXPECT_EQ(sheet.at(0, 0)[0], 10);
  EXPECT_EQ(sheet.at(5, 1)[2], 20);
  EXPECT_EQ(sheet.at(4, 0)[0], 255);
  EXPECT_EQ(sheet.at(1, 3)[1], 30);
  EXPECT_THROW(TileImages({}, 2), InputError);
}

}  // namespace
}  // namespace keypose
