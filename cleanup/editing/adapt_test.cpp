#include "cleanup/editing/adapt.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cleanup/editing/size_field.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::cleanup::adapt_test {

TEST(Remeshed, CurvedPlacesGetSmallerTriangles) {
  Mesh egg = MakeIcosphere(5);
  egg.points.col(0) *= 4;  // curvature 4 at the tips, at most 1 in the middle
  SizeRules rules;
  rules.faces = 3000;
  const Mesh mesh = Remeshed(egg, egg, EdgeSizes(egg, rules), rules.faces);
  const Eigen::VectorXd areas = FaceAreas(mesh.points, mesh.faces);
  double tip = 0, middle = 0;
  int tips = 0, middles = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    const double x = std::abs(mesh.points(mesh.faces(f, 0), 0));
    if (x > 3.8) tip += areas[f], ++tips;
    if (x < 1) middle += areas[f], ++middles;
  }
  EXPECT_LT(tip / tips,
            0.6 * middle / middles);  // areas go with curvature^(-2/3): 0.4 at the very tip
}

TEST(SplitTo, KeepsTheSurfaceAndHitsTheCount) {
  const Mesh mesh = SplitTo(MakeBox(1, 1, 1), 1000);
  EXPECT_EQ(mesh.face_count(), 1000);
  EXPECT_TRUE(CheckClosed(mesh).closed());
  EXPECT_NEAR(SurfaceArea(mesh.points, mesh.faces), 6, 1e-12);
}

}  // namespace keypose::cleanup::adapt_test
