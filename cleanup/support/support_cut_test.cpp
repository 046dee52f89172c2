#include "cleanup/support/support_cut.h"

#include <gtest/gtest.h>

#include "cleanup/testing/damaged_meshes.h"
#include "cleanup/testing/pole_on_disc.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::cleanup::support_cut_test {

TEST(FindSupport, PlateBelowAPoleIsFoundALittleAboveItsTop) {
  const Mesh mesh = PoleOnDisc(0.6);
  ASSERT_TRUE(CheckClosed(mesh).closed());
  const auto plane = FindSupport(mesh);
  ASSERT_TRUE(plane);
  EXPECT_GT(plane->normal.z(), 0.9999);
  EXPECT_NEAR(plane->offset, 0.03 + 0.005 * BoundingDiagonal(mesh.points), 1e-6);
}

TEST(FindSupport, FiguresWithoutAStandHaveNone) {
  EXPECT_FALSE(FindSupport(MakeIcosphere(3)));
  EXPECT_FALSE(FindSupport(MakeBox(1, 2, 3)));
  EXPECT_FALSE(FindSupport(MakeCylinder(0.1, 1, 24, 10)));
  EXPECT_FALSE(FindSupport(PoleOnDisc(0.12)));  // a foot, hardly wider than the leg
  for (const int limb : {1, 3}) EXPECT_FALSE(FindSupport(MakeFigure(1, limb)));
}

TEST(ClippedAbove, HalfABoxHasHalfItsSidesAndAFlatBorder) {
  const Mesh half = ClippedAbove(MakeBox(1, 1, 2), {Eigen::Vector3d::UnitZ(), 1});
  EXPECT_NEAR(SurfaceArea(half.points, half.faces), 5, 1e-12);
  for (int f = 0; f < half.face_count(); ++f)
    for (int k = 0; k < 3; ++k) EXPECT_GE(half.points(half.faces(f, k), 2), 1 - 1e-12);
}

}  // namespace keypose::cleanup::support_cut_test
