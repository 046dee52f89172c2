#include "cleanup/editing/size_field.h"

#include <gtest/gtest.h>

#include "core/surfaces/shapes.h"

namespace keypose::cleanup::size_field_test {

TEST(MaxCurvature, IsOneOverTheRadius) {
  Mesh sphere = MakeIcosphere(4);
  sphere.points *= 0.5;
  const Eigen::VectorXd curvature = MaxCurvature(sphere);
  EXPECT_NEAR(curvature.mean(), 2, 0.1);
  EXPECT_NEAR(curvature.minCoeff(), 2, 0.4);  // fans of five faces
  EXPECT_NEAR(curvature.maxCoeff(), 2, 0.4);
  const Mesh rod = MakeCylinder(0.1, 2, 48, 60);
  const Eigen::VectorXd along = MaxCurvature(rod);
  for (int v = 0; v < 48 * 61; ++v)
    if (rod.points(v, 2) > 0.3 && rod.points(v, 2) < 1.7) {
      ASSERT_NEAR(along[v], 10, 0.5);
    }
}

TEST(Thickness, IsTheDiameterOfARod) {
  const Mesh rod = MakeCylinder(0.1, 2, 48, 60);
  const Eigen::VectorXd thickness = Thickness(rod);
  for (int v = 0; v < 48 * 61; ++v)
    if (rod.points(v, 2) > 0.3 && rod.points(v, 2) < 1.7) {
      ASSERT_NEAR(thickness[v], 0.2, 0.002);
    }
}

}  // namespace keypose::cleanup::size_field_test
