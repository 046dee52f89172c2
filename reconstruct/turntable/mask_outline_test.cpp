#include "reconstruct/turntable/mask_outline.h"

#include <gtest/gtest.h>

#include <cmath>

namespace keypose::reconstruct::mask_outline_test {

constexpr int kSide = 120;
constexpr double kRadius = 40;

Image8 Disc() {
  Image8 mask(kSide, kSide, 1);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      if (std::hypot(x + 0.5 - 60, y + 0.5 - 60) < kRadius) *mask.at(x, y) = 255;
  return mask;
}

Camera Lens() {
  Camera camera;
  camera.width = camera.height = kSide;
  camera.fx = camera.fy = 100;
  camera.cx = camera.cy = 60;
  return camera;
}

TEST(MakeOutline, OfADiscHasItsAreaItsMiddleAndRaysThroughItsRim) {
  const MaskOutline outline = MakeOutline(Disc(), Lens(), 4);
  EXPECT_NEAR(outline.area, EIGEN_PI * kRadius * kRadius / 1e4, 0.005);
  EXPECT_NEAR((outline.middle - Eigen::Vector3d(0, 0, 1)).norm(), 0, 1e-9);
  ASSERT_GT(outline.rays.size(), 100u);
  for (const Eigen::Vector3d& ray : outline.rays)
    EXPECT_NEAR(ray.head<2>().norm() * 100, kRadius, 1.5);
}

TEST(MakeOutline, DistancesArePositiveOutsideInPixelsOfTheRaster) {
  const ImageF distance = MakeOutline(Disc(), Lens(), 4).distance;
  ASSERT_EQ(distance.width, 30);
  // The sweeps' steps are 1 and the root of 2, so distances err by up to 8 %.
  for (const double away : {-20.0, -8.0, 8.0, 16.0})
    EXPECT_NEAR(DistanceAt(distance, (60 + kRadius + away) / 4, 15), away / 4,
                0.3 + 0.08 * std::abs(away) / 4)
        << away;
}

TEST(MakeOutline, AnEmptyMaskHasNone) {
  const MaskOutline outline = MakeOutline(Image8(kSide, kSide, 1), Lens(), 4);
  EXPECT_TRUE(outline.rays.empty());
  EXPECT_EQ(outline.area, 0);
}

TEST(DistanceAt, BeyondTheRasterItIsTheBorders) {
  ImageF raster(2, 2, 1);
  raster.data = {1, 2, 3, 4};
  EXPECT_NEAR(DistanceAt(raster, -3, -3), 1, 1e-6);
  EXPECT_NEAR(DistanceAt(raster, 1, 0.5), 1.5, 1e-6);
  EXPECT_NEAR(DistanceAt(raster, 9, 9), 4, 0.01);
}

}  // namespace keypose::reconstruct::mask_outline_test
