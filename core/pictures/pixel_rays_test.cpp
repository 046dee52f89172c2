#include "core/pictures/pixel_rays.h"

#include <gtest/gtest.h>

namespace keypose::pixel_rays_test {

TEST(PixelRays, GoWhereTheCameraLooks) {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 500;
  camera.cx = 320, camera.cy = 240;
  camera.k1 = -0.2, camera.k2 = 0.05, camera.p1 = 1e-3, camera.p2 = -2e-3;
  const PixelRays rays(camera);
  for (const int x : {0, 1, 320, 639})
    for (const int y : {0, 1, 240, 479}) {
      const Eigen::Vector3d corner = rays.At(x, y, 0, 0), middle = rays.At(x, y, 0.5, 0.5);
      EXPECT_EQ(corner.head<2>(), camera.Unproject(Eigen::Vector2d(x, y)).head<2>());
      EXPECT_EQ(corner.z(), 1);
      const Eigen::Vector3d exact = camera.Unproject(Eigen::Vector2d(x + 0.5, y + 0.5));
      EXPECT_LT((middle - exact).norm(), 1e-3 / camera.fx) << "the lens bends little in a pixel";
    }
}

}  // namespace keypose::pixel_rays_test
