#include "cleanup/support/support_cut.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cleanup/repair/intersections.h"
#include "cleanup/strategies/cleanup.h"
#include "cleanup/testing/damaged_meshes.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::cleanup::support_plane_test {

/// A pole of radius 0.1 and height 1 that grows out of a disc of thickness 0.03: one surface of
/// revolution.
Mesh PoleOnDisc(double disc_radius) {
  return MakeRevolved({{0.1, 1},
                       {0.1, 0.8},
                       {0.1, 0.6},
                       {0.1, 0.4},
                       {0.1, 0.2},
                       {0.1, 0.06},
                       {0.1, 0.03},
                       {0.5 * (0.1 + disc_radius), 0.03},
                       {disc_radius, 0.03},
                       {disc_radius, 0}},
                      48);
}

CleanupOptions Faces(int faces) {
  CleanupOptions options;
  options.faces = faces;
  return options;
}

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

TEST(MakeClosedManifold, PlateIsCutOffWithAFlatCap) {
  const Mesh mesh = PoleOnDisc(0.6);
  const CleanupResult result = MakeClosedManifold(mesh, Faces(3000));
  EXPECT_EQ(result.supports_removed, 1);
  EXPECT_TRUE(CheckClosed(result.mesh).closed());
  EXPECT_FALSE(SelfIntersects(result.mesh));
  const double cut = 0.03 + 0.005 * BoundingDiagonal(mesh.points);
  EXPECT_NEAR(result.mesh.points.col(2).minCoeff(), cut, 1e-3);
  EXPECT_LT(result.mesh.points.leftCols(2).rowwise().norm().maxCoeff(), 0.101);
  const double polygon = 48.0 / 2 * std::sin(2 * EIGEN_PI / 48) * 0.01;
  EXPECT_NEAR(result.volume, polygon * (1 - cut), 0.01 * polygon);
  EXPECT_EQ(MakeClosedManifold(result.mesh, Faces(3000)).strategy, "as-is");
}

TEST(MakeClosedManifold, PlateStaysWhenAsked) {
  CleanupOptions options = Faces(3000);
  options.support = "keep";
  const Mesh mesh = PoleOnDisc(0.6);
  const CleanupResult result = MakeClosedManifold(mesh, options);
  EXPECT_EQ(result.strategy, "as-is");
  EXPECT_EQ(result.mesh.points, mesh.points);
}

TEST(MakeClosedManifold, ClothUnderAFigureGoes) {
  // An open, wavy sheet just below the feet of a figure. The search for pieces treats both as one
  // object.
  const Mesh figure = MakeFigure(5, 3);
  const double bottom = figure.points.col(2).minCoeff();
  const int n = 40;
  Mesh cloth;
  cloth.points.resize(n * n, 3);
  cloth.faces.resize(2 * (n - 1) * (n - 1), 3);
  int f = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      cloth.points.row(i * n + j) << 0.04 + 0.012 * (i - n / 2), 0.02 + 0.012 * (j - n / 2),
          bottom - 0.0006 + 0.0004 * std::sin(i) * std::cos(j);
      if (i == 0 || j == 0) continue;
      const int c = i * n + j;
      cloth.faces.row(f++) << c - n - 1, c - 1, c;
      cloth.faces.row(f++) << c - n - 1, c, c - n;
    }
  const CleanupResult result = MakeClosedManifold(Together(figure, cloth), Faces(4000));
  EXPECT_EQ(result.supports_removed, 1);
  EXPECT_EQ(result.components, 1);
  EXPECT_NEAR(result.volume, SignedVolume(figure.points, figure.faces),
              0.05 * SignedVolume(figure.points, figure.faces));
  EXPECT_LT(BoundingDiagonal(result.mesh.points), 1.01 * BoundingDiagonal(figure.points));
}

TEST(ClippedAbove, HalfABoxHasHalfItsSidesAndAFlatBorder) {
  const Mesh half = ClippedAbove(MakeBox(1, 1, 2), {Eigen::Vector3d::UnitZ(), 1});
  EXPECT_NEAR(SurfaceArea(half.points, half.faces), 5, 1e-12);
  for (int f = 0; f < half.face_count(); ++f)
    for (int k = 0; k < 3; ++k) EXPECT_GE(half.points(half.faces(f, k), 2), 1 - 1e-12);
}

}  // namespace keypose::cleanup::support_plane_test
