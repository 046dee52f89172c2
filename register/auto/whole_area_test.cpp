#include "register/auto/whole_area.h"

#include <gtest/gtest.h>

#include "core/surfaces/shapes.h"

namespace keypose::registration::whole_area_test {

TEST(WholeArea, OfAClosedSurfaceIsItsArea) {
  double filled = 1;
  EXPECT_NEAR(WholeArea(MakeBox(1, 2, 3), filled), 22, 1e-12);
  EXPECT_EQ(filled, 0);
}

TEST(WholeArea, AHoleCountsAsADiscOfItsRim) {
  Mesh box = MakeBox(1, 1, 1);
  box.faces.conservativeResize(box.faces.rows() - 2, 3);  // one side
  double filled = 0;
  const double disc = 4 / EIGEN_PI;  // of circumference 4
  EXPECT_NEAR(WholeArea(box, filled), 5 + disc, 1e-12);
  EXPECT_NEAR(filled, disc / (5 + disc), 1e-12);
}

}  // namespace keypose::registration::whole_area_test
