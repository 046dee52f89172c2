#include "motion/tracking/mask_silhouette.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/values/angles.h"
#include "motion/tracking/testing/filmed_body.h"

namespace keypose::motion::mask_silhouette_test {

TEST(Silhouette, DistanceIsThatToADisc) {
  View view = CameraAt(0, 1, 0);
  view.camera.k1 = view.camera.k2 = 0;
  Image8 mask(kSide, kSide, 1);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      if (std::hypot(x + 0.5 - 160, y + 0.5 - 150) < 60) *mask.at(x, y) = 255;
  const SilhouetteCamera camera(view, 1);
  const Silhouette s = MakeSilhouette(camera, 0, camera.Reduced(mask), 200);
  const Eigen::Vector2d shift(camera.pinhole().cx - s.pinhole.cx,
                              camera.pinhole().cy - s.pinhole.cy);
  for (const double r : {40.0, 58.0, 60.0, 66.0, 80.0}) {
    Eigen::Vector2d gradient;
    const Eigen::Vector2d direction(0.6, 0.8);
    const Eigen::Vector2d pixel = Eigen::Vector2d(159.5, 149.5) + r * direction - shift;
    EXPECT_NEAR(s.Distance(pixel, &gradient), r - 60, 0.6) << r;  // a pixel's half
    EXPECT_GT(gradient.normalized().dot(direction), 0.95) << r;   // the mask's staircase
  }
  // pixels along a circle: from its length to that times the diagonal's root of two
  const double length = s.outline_step * static_cast<double>(s.outline.size());
  EXPECT_GT(length, 0.9 * 2 * kPi * 60);
  EXPECT_LT(length, 1.5 * 2 * kPi * 60);
}

}  // namespace keypose::motion::mask_silhouette_test
