// Outlines of mattes and of meshes.
#include "composite/locating/outline/matte_outline.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/values/size_of.h"

namespace keypose::composite::matte_outline_test {

TEST(MatteOutline, OfADiskLiesOnItsCircle) {
  Image8 matte(200, 200, 1);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x)
      if (std::hypot(x + 0.5 - 100, y + 0.5 - 100) < 60) *matte.at(x, y) = 255;
  const MatteOutline outline(matte);
  // One point for each pixel of the circle's length, within the quarter that its direction allows.
  EXPECT_NEAR(SizeOf(outline.points()), 2 * 60 * 3.14159, 60);
  double mean = 0;
  for (const OutlinePoint& point : outline.points()) {
    const Eigen::Vector2d from = point.pixel - Eigen::Vector2d(100, 100);
    EXPECT_LT(std::abs(from.norm() - 60), 0.8);
    EXPECT_GT(from.normalized().dot(point.normal), 0.95);
    mean += (from.norm() - 60) / SizeOf(outline.points());
  }
  EXPECT_LT(std::abs(mean), 0.1);
}

}  // namespace keypose::composite::matte_outline_test
