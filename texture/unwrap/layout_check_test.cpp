#include "texture/unwrap/layout_check.h"

#include <gtest/gtest.h>

#include <cmath>

namespace keypose::texture::layout_check_test {

/// A unit square of two triangles in the plane z = 0, with the texture coordinates `uvs`.
Mesh Square(const UvsX2& uvs) {
  Mesh mesh;
  mesh.points.resize(4, 3);
  mesh.points << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0;
  mesh.faces.resize(2, 3);
  mesh.faces << 0, 1, 2, 0, 2, 3;
  mesh.uvs = OnGrid(uvs);
  mesh.uv_faces = mesh.faces;
  return mesh;
}

TEST(FindAtlasFaults, SquareHasNone) {
  UvsX2 uvs(4, 2);
  uvs << 0, 0, 1, 0, 1, 1, 0, 1;
  EXPECT_TRUE(FindAtlasFaults(Square(uvs)).none());
}

TEST(FindAtlasFaults, MirroredSquareIsFlipped) {
  UvsX2 uvs(4, 2);
  uvs << 1, 0, 0, 0, 0, 1, 1, 1;
  EXPECT_EQ(FindAtlasFaults(Square(uvs)).flipped, 2);
}

TEST(FindAtlasFaults, TriangleWithoutAreaIsFlipped) {
  UvsX2 uvs(4, 2);
  uvs << 0, 0, 0.5, 0.5, 1, 1, 0, 1;
  EXPECT_EQ(FindAtlasFaults(Square(uvs)).flipped, 1);
}

TEST(FindAtlasFaults, SeesTwoChartsThatCrossAndOneInsideAnother) {
  UvsX2 uvs(4, 2);
  uvs << 0.1, 0.1, 0.9, 0.1, 0.9, 0.9, 0.1, 0.9;
  const Mesh large = Square(uvs);
  for (const bool nested : {false, true}) {
    Mesh both = large;
    both.points.conservativeResize(8, 3);
    both.points.bottomRows(4) = large.points;
    both.faces.conservativeResize(4, 3);
    both.faces.bottomRows(2) = large.faces.array() + 4;
    both.uv_faces = both.faces;
    both.uvs.conservativeResize(8, 2);
    const Eigen::RowVector2d shift =
        nested ? Eigen::RowVector2d(0.25, 0.25) : Eigen::RowVector2d(0.5, 0.5);
    both.uvs.bottomRows(4) = OnGrid((large.uvs * 0.5).rowwise() + shift);
    const AtlasFaults faults = FindAtlasFaults(both);
    EXPECT_EQ(faults.crossings > 0, !nested);
    EXPECT_TRUE(!nested || faults.nested == 1);
    EXPECT_EQ(faults.flipped, 0);
  }
}

TEST(FindAtlasFaults, FanThatWindsAroundTwiceCrossesItself) {
  // No triangle flips, but the fan covers the plane twice: only its boundary reveals that.
  const int n = 12;
  Mesh fan;
  fan.points = PointsX3::Zero(n + 2, 3);
  fan.uvs.resize(n + 2, 2);
  fan.uvs.row(n + 1) << 0.5, 0.5;
  fan.faces.resize(n, 3);
  for (int i = 0; i <= n; ++i) {
    const double angle = 3.8 * EIGEN_PI * i / n;
    fan.uvs.row(i) << 0.5 + (0.2 + 0.01 * i) * std::cos(angle),
        0.5 + (0.2 + 0.01 * i) * std::sin(angle);
    if (i < n) fan.faces.row(i) << n + 1, i, i + 1;
  }
  fan.uvs = OnGrid(fan.uvs);
  fan.uv_faces = fan.faces;
  const AtlasFaults faults = FindAtlasFaults(fan);
  EXPECT_EQ(faults.flipped, 0);
  EXPECT_GT(faults.crossings, 0);
}

TEST(FindAtlasFaults, OutsideOfTheSquareIsAFault) {
  UvsX2 uvs(4, 2);
  uvs << 0, 0, 1.25, 0, 1.25, 1, 0, 1;
  EXPECT_EQ(FindAtlasFaults(Square(uvs)).outside, 2);
}

TEST(MeasureAtlasStretch, KnownAffineMap) {
  // The unit square onto 0.8 x 0.2: after scaling to equal area the map back stretches by 2 and
  // 1/2.
  UvsX2 uvs(4, 2);
  uvs << 0, 0, 0.8, 0, 0.8, 0.2, 0, 0.2;
  const AtlasStretch stretch = MeasureAtlasStretch(Square(uvs));
  EXPECT_NEAR(stretch.linf, 2, 1e-9);
  EXPECT_NEAR(stretch.l2, std::sqrt((4 + 0.25) / 2), 1e-9);
  EXPECT_NEAR(stretch.conformal_mean, 4, 1e-9);
  EXPECT_NEAR(stretch.area_deviation, 0, 1e-9);
  EXPECT_NEAR(stretch.utilisation, 0.16, 1e-9);
}

}  // namespace keypose::texture::layout_check_test
