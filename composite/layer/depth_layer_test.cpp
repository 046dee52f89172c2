#include "composite/layer/depth_layer.h"

#include <gtest/gtest.h>

namespace keypose::composite::depth_layer_test {

/// A square across the view, in pixels of the camera.
struct Square {
  PointsX3 points{4, 3};
  FacesX3 faces{2, 3};
  Square(const Camera& camera, double left, double right, double depth) {
    const double pixels[4][2] = {{left, 5}, {right, 5}, {right, 25}, {left, 25}};
    for (int i = 0; i < 4; ++i)
      points.row(i) = (depth * camera.Unproject({pixels[i][0], pixels[i][1]})).transpose();
    faces << 0, 2, 1, 0, 3, 2;
  }
};

/// Far below all.
Ground FarTable() {
  Ground table;
  table.origin = Eigen::Vector3d(0, 100, 0), table.up = -Eigen::Vector3d::UnitY();
  return table;
}

const View kView{"", {40, 30, 50, 50, 20, 15}, {}};

TEST(DepthLayer, DepthIsAlongTheAxisAlsoAtTheSide) {
  const Square square(kView.camera, 4, 36, 2);
  const ImageF depth =
      DepthLayer(square.points, square.faces, kView, PixelRays(kView.camera), 2, FarTable());
  EXPECT_NEAR(*depth.at(20, 15), 2, 1e-6);
  EXPECT_NEAR(*depth.at(35, 24), 2, 1e-6) << "the ray there is 7 % longer";
  EXPECT_EQ(*depth.at(2, 15), kNoDepth);
}

TEST(DepthLayer, WhatAPropHidesHasNone) {
  const Square square(kView.camera, 4, 36, 2), prop(kView.camera, 20, 40, 1);
  const RayScene props(prop.points, prop.faces);
  const ImageF depth = DepthLayer(square.points, square.faces, kView, PixelRays(kView.camera), 2,
                                  FarTable(), &props);
  EXPECT_NEAR(*depth.at(10, 15), 2, 1e-6);
  EXPECT_EQ(*depth.at(30, 15), kNoDepth);
}

}  // namespace keypose::composite::depth_layer_test
