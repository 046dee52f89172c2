#include "cleanup/strategies/repair_strategies.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cleanup/repair/intersections.h"
#include "cleanup/strategies/cleanup.h"
#include "cleanup/testing/damaged_meshes.h"
#include "cleanup/testing/pawn.h"
#include "cleanup/testing/pole_on_disc.h"
#include "cleanup/testing/windowed_slab.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"

namespace keypose::cleanup::repair_strategies_test {

using Eigen::Vector2d;

/// Area of the faces that lie at z = 0.
double FlatArea(const Mesh& mesh) {
  double area = 0;
  const Eigen::VectorXd areas = FaceAreas(mesh.points, mesh.faces);
  for (int f = 0; f < mesh.face_count(); ++f) {
    bool flat = true;
    for (int k = 0; k < 3; ++k) flat = flat && std::abs(mesh.points(mesh.faces(f, k), 2)) < 1e-9;
    if (flat) area += areas[f];
  }
  return area;
}

TEST(MakeClosedManifold, SolesAreFlatAtTheGroundAndNothingLiesBelow) {
  CleanupOptions options;
  options.faces = 4000;
  const CleanupResult result = MakeClosedManifold(WithCap(), options, nullptr, {}, 0.0);
  EXPECT_TRUE(CheckClosed(result.mesh).closed());
  EXPECT_FALSE(SelfIntersects(result.mesh));
  EXPECT_EQ(result.mesh.points.col(2).minCoeff(), 0);
  const Mesh truth = TruePawn();
  const double sole = 64.0 / 2 * std::sin(2 * EIGEN_PI / 64) * 0.16;  // of a polygon of 64 corners
  EXPECT_NEAR(FlatArea(result.mesh), sole,
              0.08 * sole);  // the ring of faces at the edge need not lie flat
  EXPECT_NEAR(result.volume, SignedVolume(truth.points, truth.faces), 0.003 * result.volume);
  EXPECT_GT(result.cut_below_ground_over_diag, 0.02);
  const CleanupResult again = MakeClosedManifold(result.mesh, options, nullptr, {}, 0.0);
  EXPECT_EQ(again.strategy, "as-is");
  EXPECT_EQ(again.mesh.points, result.mesh.points);
  // Without the ground the cap stays.
  EXPECT_LT(MakeClosedManifold(WithCap(), options).mesh.points.col(2).minCoeff(), -0.9 * kCap);
}

const Window kNarrow = {3, 6, 3, 6}, kBroad = {9, 16, 2, 7}, kThird = {17, 20, 3, 6};

TEST(MakeClosedManifold, PhotographsDecideWhichHandlesStay) {
  const Mesh both = Slab({kNarrow, kBroad});
  const std::vector<SightLine> lines = LinesOf(PhotographOfSlab(Slab({kNarrow}), {-15, 0, 15}));
  CleanupOptions options;
  options.faces = 3000;
  const CleanupResult result = MakeClosedManifold(both, options, nullptr, lines);
  EXPECT_EQ(result.genus, 1);
  EXPECT_EQ(result.handles_cut, 1);
  EXPECT_EQ(result.handles_seen_through, 1);
  EXPECT_TRUE(Open(result.mesh, kNarrow));
  const CleanupResult again = MakeClosedManifold(result.mesh, options, nullptr, lines);
  EXPECT_EQ(again.strategy, "as-is");
  EXPECT_EQ(again.mesh.points, result.mesh.points);
  EXPECT_EQ(MakeClosedManifold(both, options).genus, 0);
}

TEST(MakeClosedManifold, GenusForcesTheNumberOfHandles) {
  const Mesh both = Slab({kNarrow, kBroad});
  CleanupOptions options;
  options.faces = 3000;
  for (const int genus : {0, 1, 2}) {
    options.genus = genus;
    EXPECT_EQ(MakeClosedManifold(both, options).genus, genus);
  }
  options.genus = 3;
  EXPECT_THROW(MakeClosedManifold(both, options), InputError);
}

CleanupOptions Faces(int faces) {
  CleanupOptions options;
  options.faces = faces;
  return options;
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

}  // namespace keypose::cleanup::repair_strategies_test
