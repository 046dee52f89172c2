#include "register/auto/flipped_face_repair.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry.h"
#include "core/parallel.h"

namespace keypose::registration {
namespace {

constexpr double kGap = 0.06;

/// A sheet folded onto itself: two walls, their outsides facing away from each other, kGap apart,
/// joined at x = 0.
Mesh Folded(int along, int across) {
  Mesh mesh;
  mesh.points.resize(2 * along * across, 3);
  for (int i = 0; i < 2 * along; ++i)
    for (int j = 0; j < across; ++j) {
      const double s = (i - along + 0.5) / along;
      mesh.points.row(i * across + j) << std::abs(s), static_cast<double>(j) / (across - 1),
          s > 0 ? kGap / 2 : -kGap / 2;
    }
  mesh.faces.resize(2 * (2 * along - 1) * (across - 1), 3);
  Eigen::Index f = 0;
  for (int i = 0; i + 1 < 2 * along; ++i)
    for (int j = 0; j + 1 < across; ++j) {
      const int a = i * across + j, b = a + across;
      mesh.faces.row(f++) << a, b, a + 1;
      mesh.faces.row(f++) << a + 1, b, b + 1;
    }
  return mesh;
}

/// The upper wall dented until it lies beyond the middle of the gap by `beyond` of it.
PointsX3 Dented(const PointsX3& points, double beyond) {
  PointsX3 dented = points;
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    const double r = std::hypot(points(v, 0) - 0.55, points(v, 1) - 0.5) / 0.25;
    if (points(v, 2) > 0 && r < 1)
      dented(v, 2) -= (0.5 + beyond) * kGap * std::pow(1 - r * r, 0.25);
  }
  return dented;
}

FlippedFaceRepair Mend(const Mesh& source, const PointsX3& moved, const Mesh& target) {
  const std::vector<Eigen::Matrix3d> maps(source.vertex_count(), Eigen::Matrix3d::Identity());
  return RepairFlippedFaces({source.points, source.faces, moved, maps, 1e300, 0.0016, 8500},
                            target.points, target.faces);
}

TEST(RepairFlippedFaces, ADentThroughTheMiddleOfAGapGoesBack) {
  const Mesh source = Folded(20, 20), target = Folded(47, 45);
  ASSERT_EQ(Mend(source, source.points, target).before, 0);
  const PointsX3 moved = Dented(source.points, 0.05);
  const FlippedFaceRepair result = Mend(source, moved, target);
  EXPECT_GT(result.before, 40);
  EXPECT_EQ(result.after, 0);
  EXPECT_LT((result.points - source.points).rowwise().norm().maxCoeff(),
            (moved - source.points).rowwise().norm().maxCoeff());
  EXPECT_LT((result.points - source.points).norm(), (moved - source.points).norm());
  const PointsX3 before = FaceNormals(source.points, source.faces),
                 after = FaceNormals(result.points, source.faces);
  for (Eigen::Index f = 0; f < source.faces.rows(); ++f)
    EXPECT_GT(before.row(f).dot(after.row(f)), 0) << f;
}

TEST(RepairFlippedFaces, WhatIsFarFromTheDentStaysWhereItIs) {
  const Mesh source = Folded(20, 20), target = Folded(47, 45);
  const PointsX3 moved = Dented(source.points, 0.05);
  const FlippedFaceRepair result = Mend(source, moved, target);
  for (Eigen::Index v = 0; v < moved.rows(); ++v) {
    const bool far =
        source.points(v, 2) < 0 || std::hypot(moved(v, 0) - 0.55, moved(v, 1) - 0.5) > 0.5;
    if (far) {
      EXPECT_EQ(result.points.row(v), moved.row(v)) << v;
    }
  }
}

TEST(RepairFlippedFaces, AMeshThatLiesRightIsReturnedBitForBit) {
  const Mesh source = Folded(20, 20), target = Folded(47, 45);
  const PointsX3 moved = Dented(source.points, -0.2);
  const FlippedFaceRepair result = Mend(source, moved, target);
  EXPECT_EQ(result.before, 0);
  EXPECT_EQ(result.points, moved);
}

TEST(RepairFlippedFaces, SameBitsForAnyThreadCount) {
  const Mesh source = Folded(20, 20), target = Folded(47, 45);
  const PointsX3 moved = Dented(source.points, 0.05);
  SetThreadCount(1);
  const PointsX3 one = Mend(source, moved, target).points;
  SetThreadCount(2);
  const PointsX3 two = Mend(source, moved, target).points;
  SetThreadCount(0);
  EXPECT_EQ(one, two);
}

TEST(RepairFlippedFaces, AFoldOpensByItself) {
  // Three neighbouring vertices of one wall are pulled over the next ones, so that faces between
  // them are upside down.
  const Mesh source = Folded(20, 20), target = Folded(47, 45);
  PointsX3 moved = source.points;
  for (int j = 9; j < 12; ++j) moved(30 * 20 + j, 0) += 0.08;
  const FlippedFaceRepair result = Mend(source, moved, target);
  EXPECT_GT(result.before, 0);
  EXPECT_EQ(result.after, 0);
  EXPECT_LT((result.points - source.points).rowwise().norm().maxCoeff(), 0.02);
}

TEST(RepairFlippedFaces, NeverEndsWorseThanItBegan) {
  // The whole upper wall lies on the lower one's side, further than any slip.
  const Mesh source = Folded(20, 20), target = Folded(47, 45);
  const FlippedFaceRepair result = Mend(source, Dented(source.points, 0.9), target);
  EXPECT_GT(result.before, 0);
  EXPECT_LE(result.after, result.before);
  EXPECT_TRUE(result.points.allFinite());
}

TEST(RepairFlippedFaces, ATargetWithoutTheDirectionMovesNothingOffTheMap) {
  // Inside out everywhere: no face has a wall of its own.
  const Mesh source = Folded(10, 10);
  Mesh target = Folded(23, 21);
  target.faces.col(1).swap(target.faces.col(2));
  const FlippedFaceRepair result = Mend(source, source.points, target);
  EXPECT_GT(result.before, 0);
  EXPECT_LE(result.after, result.before);
  EXPECT_LT((result.points - source.points).rowwise().norm().maxCoeff(), 0.1);
}

}  // namespace
}  // namespace keypose::registration
