#include "reconstruct/stereo/frontier_cloud.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/statistics.h"
#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "reconstruct/stereo/dense.h"
#include "reconstruct/testing/rendered_ring.h"

namespace keypose::reconstruct::frontier_cloud_test {

constexpr double kPixel = 0.01;

// Frontier points along the plane z = 0, every second pixel of 40 x 40.
std::vector<FrontierPoint> PlaneOfFrontierPoints() {
  std::vector<FrontierPoint> frontier;
  for (int y = -10; y <= 10; ++y)
    for (int x = -10; x <= 10; ++x) {
      FrontierPoint touch;
      touch.point = 2 * kPixel * Eigen::Vector3d(x, y, 0);
      touch.normal = Eigen::Vector3d::UnitZ();
      touch.footprint = kPixel;
      touch.weight = 1;
      frontier.push_back(touch);
    }
  return frontier;
}

// One point, at the given pixels beside the middle and above the plane.
PointCloud At(double x_px, double z_px, const Eigen::Vector3d& normal = Eigen::Vector3d::UnitZ()) {
  PointCloud cloud;
  cloud.points = kPixel * Eigen::RowVector3d(x_px, 0.3, z_px);
  cloud.normals = normal.transpose();
  cloud.colors = ColorsX3::Constant(1, 3, 128);
  cloud.confidence = Eigen::VectorXf::Ones(1);
  return cloud;
}

int Dropped(PointCloud cloud,
            const std::vector<FrontierPoint>& frontier = PlaneOfFrontierPoints()) {
  return DropWhatFrontierPointsContradict(frontier, {}, &cloud);
}

TEST(DropWhatFrontierPointsContradict, WhatLiesAboveOrBelowThem) {
  for (const double height : {-15.0, -3.0, -1.7, 1.7, 3.0, 15.0})
    EXPECT_EQ(Dropped(At(1, height)), 1) << height;
  for (const double height : {-1.3, -0.9, 0.0, 0.9, 1.3})
    EXPECT_EQ(Dropped(At(1, height)), 0) << height;
}

TEST(DropWhatFrontierPointsContradict, NothingOfAnotherSheetNorFarOff) {
  EXPECT_EQ(Dropped(At(1, -3, -Eigen::Vector3d::UnitZ())), 0) << "the back of a thin part";
  EXPECT_EQ(Dropped(At(1, -3, Eigen::Vector3d::UnitX())), 0) << "a wall";
  EXPECT_EQ(Dropped(At(1, -18)), 0) << "out of reach";
  EXPECT_EQ(Dropped(At(28, -3)), 0) << "beside all of them";
}

TEST(DropWhatFrontierPointsContradict, OnlyWhatTwoContradictAndNoneConfirms) {
  EXPECT_EQ(Dropped(At(0, -3), {PlaneOfFrontierPoints()[220]}), 0);
  std::vector<FrontierPoint> frontier = PlaneOfFrontierPoints();
  EXPECT_EQ(Dropped(At(0, -3), frontier), 1);
  frontier[220].point.z() = -2.5 * kPixel;
  EXPECT_EQ(Dropped(At(0, -3), frontier), 0);
  EXPECT_EQ(Dropped(At(0, -3), {}), 0);
}

TEST(FrontierCloud, HasTheColourInsideOfTheOutline) {
  View view;
  view.camera = {.width = 100, .height = 100, .fx = 100, .fy = 100, .cx = 50, .cy = 50};
  view.camera_from_world = LookAt({0, -1, 0}, {0, 0, 0});  // a pixel is a hundredth wide
  Image8 image(100, 100, 3, 0), mask(100, 100, 1, 0);
  for (int y = 50; y < 80; ++y)
    for (int x = 20; x < 80; ++x)
      *mask.at(x, y) = 255, image.at(x, y)[0] = 200, image.at(x, y)[1] = 100;
  const std::vector<PreparedView> views = {PrepareView(view, 0, image, mask, 1.0, 1)};
  FrontierPoint touch;
  touch.point = {0.1, 0, 0}, touch.normal = Eigen::Vector3d::UnitZ(), touch.footprint = 0.01;
  const PointCloud cloud = FrontierCloud({touch, touch}, views);
  ASSERT_EQ(cloud.points.rows(), 2);
  EXPECT_EQ(cloud.points.row(1), Eigen::RowVector3d(0.1, 0, 0));
  EXPECT_EQ(cloud.normals.row(1), Eigen::RowVector3d(0, 0, 1));
  EXPECT_EQ(cloud.confidence[1], 1);
  EXPECT_EQ(cloud.colors(1, 0), 200);
  EXPECT_EQ(cloud.colors(1, 1), 100);
}

// A ball without texture has no matches: apart from its hull only frontier points are known.
TEST(FrontierCloud, OfAFlatBallLiesOnItsSurface) {
  const testing::RenderedScene rendered = testing::RenderRing({.views = 30, .contrast = 0});
  DenseOptions options;
  const DenseResult with = ReconstructDense(testing::Prepared(rendered), rendered.scene, options);
  ASSERT_GT(with.frontier_points, 60);
  const RayScene truth(rendered.truth.points, rendered.truth.faces);
  std::vector<double> misses;
  for (int i = 0; i < with.frontier_points; ++i)
    misses.push_back(
        std::sqrt(truth.ClosestPoint(with.cloud.points.row(with.cloud.points.rows() - 1 - i))
                      .squared_distance) /
        rendered.footprint);
  EXPECT_LT(UpperMedian(misses), 0.75);
  EXPECT_LT(QuantileAbove(misses, 0.9), 1.5);
  options.frontier_points = false;
  const DenseResult without =
      ReconstructDense(testing::Prepared(rendered), rendered.scene, options);
  EXPECT_EQ(without.frontier_points, 0);
  EXPECT_EQ(without.contradicted_points, 0);
  EXPECT_EQ(without.cloud.points.rows(),
            with.cloud.points.rows() - with.frontier_points + with.contradicted_points);
}

}  // namespace keypose::reconstruct::frontier_cloud_test
