#include "interpolate/volume/volumetric.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <utility>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/camera.h"
#include "core/values/errors.h"
#include "interpolate/surface/arap.h"
#include "interpolate/testing/bars.h"

namespace keypose::interpolation::volumetric_test {

TEST(Volumetric, RigidMotionGivesRigidFrames) {
  const Bar bar(0.2);
  Similarity3 motion;
  motion.rotation = Turn(2.5, {1, 2, -1});
  motion.translation << 3, 1, -2;
  const VolumetricInterpolator solid(bar.mesh.points, Transformed(motion, bar.mesh.points),
                                     bar.mesh.faces);
  for (double t : {0.1, 0.37, 0.9}) {
    const PointsX3 frame = solid.At(t);
    for (const auto& [i, j] : UndirectedEdges(bar.mesh.faces))
      EXPECT_NEAR((frame.row(i) - frame.row(j)).norm(),
                  (bar.mesh.points.row(i) - bar.mesh.points.row(j)).norm(), 1e-10);
  }
}

TEST(Volumetric, UniformGrowthIsGeometricAndIdenticalKeysStayPut) {
  const Mesh mesh = MakeIcosphere(2);
  EXPECT_LT(Gap(VolumetricInterpolator(mesh.points, 3 * mesh.points, mesh.faces).At(0.25),
                std::pow(3, 0.25) * mesh.points),
            1e-11);
  const Bar bar(0.2);
  const PointsX3 bent = bar.Bent(2);
  EXPECT_LT(Gap(VolumetricInterpolator(bent, bent, bar.mesh.faces).At(0.4), bent), 1e-11);
}

TEST(Volumetric, MiddleOfATurnBy179DegreesIs89AndAHalf) {
  const Mesh mesh = MakeBox(1, 2, 3);
  const PointsX3 u = mesh.points * Turn(179 * kPi / 180, Eigen::Vector3d::UnitZ()).transpose();
  const PointsX3 frame = VolumetricInterpolator(mesh.points, u, mesh.faces).At(0.5),
                 centred = frame.rowwise() - frame.colwise().mean();
  const PointsX3 start = mesh.points.rowwise() - mesh.points.colwise().mean();
  EXPECT_LT(Gap(centred, start * Turn(89.5 * kPi / 180, Eigen::Vector3d::UnitZ()).transpose()),
            1e-11);
}

TEST(Volumetric, EndsHaveTheKeysBitsAndFramesNearThemComeClose) {
  const Bar bar(0.15);
  const PointsX3 u = bar.Bent(4);
  const VolumetricInterpolator solid(bar.mesh.points, u, bar.mesh.faces);
  EXPECT_TRUE(SameBits(solid.At(0), bar.mesh.points));
  EXPECT_TRUE(SameBits(solid.At(1), u));
  EXPECT_LT(Gap(solid.At(1e-9), bar.mesh.points), 1e-8);
  EXPECT_LT(Gap(solid.At(1 - 1e-9), u), 1e-8);
}

TEST(Volumetric, SwappingTheKeysReversesTime) {
  const Bar bar(0.15);
  const PointsX3 v = bar.Twisted(1), u = bar.Bent(4);
  const VolumetricInterpolator there(v, u, bar.mesh.faces), back(u, v, bar.mesh.faces);
  EXPECT_NE(there.report().meshed_key, back.report().meshed_key);
  EXPECT_TRUE(SameBits(there.At(0.25), back.At(0.75)));  // 1 - 0.25 is exact
  EXPECT_LT(Gap(there.At(0.3), back.At(0.7)), 1e-12);
}

/// Mean distance from the exact pose after the best rigid fit, over the diagonal.
double MeanError(const PointsX3& frame, const PointsX3& exact) {
  return (Transformed(FitSimilarity(frame, exact, {}, false), frame) - exact)
             .rowwise()
             .norm()
             .mean() /
         BoundingDiagonal(exact);
}

TEST(Volumetric, BendsBeyondAHalfTurnPassThroughTheHalfBend) {
  const Bar bar(0.12);
  // Degrees, and twice what was measured.
  for (const auto& [degrees, most] : {std::pair{150.0, 1e-4}, {300.0, 4e-4}, {450.0, 1e-3}}) {
    const double angle = degrees * kPi / 180;
    const VolumetricInterpolator solid(bar.mesh.points, bar.Bent(angle), bar.mesh.faces);
    EXPECT_LT(MeanError(solid.At(0.5), bar.Bent(angle / 2)), most) << degrees;
    EXPECT_EQ(solid.report().inverted, 0);
  }
}

TEST(Volumetric, StrongTwistsKeepTheirCrossSectionBetterThanASurfaceAlone) {
  const Bar bar(0.12, true);
  for (double turns : {1, 2}) {
    const PointsX3 u = bar.Twisted(2 * kPi * turns), half = bar.Twisted(kPi * turns);
    const PointsX3 frame = VolumetricInterpolator(bar.mesh.points, u, bar.mesh.faces).At(0.5);
    EXPECT_GT(bar.SmallestCrossSection(frame), 0.98) << turns;
    EXPECT_LT(MeanError(frame, half), 0.005) << turns;
    const PointsX3 shell = ArapInterpolator(bar.mesh.points, u, bar.mesh.faces).At(0.5);
    const PointsX3 paper =
        ArapInterpolator(bar.mesh.points, u, bar.mesh.faces, PaperOptions()).At(0.5);
    EXPECT_LT(bar.SmallestCrossSection(paper), 0.1)
        << turns << ": the paper's surface mode does not collapse, so this test shows nothing";
    EXPECT_LT(1 - bar.SmallestCrossSection(frame), 0.7 * (1 - bar.SmallestCrossSection(shell)))
        << turns;
    EXPECT_LT(MeanError(frame, half), 0.5 * MeanError(shell, half)) << turns;
  }
}

TEST(Volumetric, VolumeOfEachBodyFollowsTheKeys) {
  Mesh mesh = Bar(0.15).mesh, ball = MakeIcosphere(2);
  const int first_faces = mesh.face_count();
  ball.points *= 0.3;
  ball.points.rowwise() += Eigen::RowVector3d(1, 0, 1);
  const int v = mesh.vertex_count();
  PointsX3 u(v + ball.vertex_count(), 3);
  u.topRows(v) = 1.2 * Bar(0.15).Bent(3);
  u.bottomRows(ball.vertex_count()) = ball.points * Eigen::Vector3d(0.5, 1, 1).asDiagonal();
  Join(mesh, ball);
  const VolumetricInterpolator solid(mesh.points, u, mesh.faces);
  EXPECT_EQ(solid.report().bodies, 2);
  for (double t : {0.2, 0.5, 0.9}) {
    const PointsX3 frame = solid.At(t);
    for (const FacesX3& faces : {mesh.faces.topRows(first_faces).eval(),
                                 mesh.faces.bottomRows(ball.face_count()).eval()}) {
      const double v0 = SignedVolume(mesh.points, faces), v1 = SignedVolume(u, faces);
      EXPECT_NEAR(SignedVolume(frame, faces) / (std::pow(v0, 1 - t) * std::pow(v1, t)), 1, 1e-9);
    }
  }
}

TEST(Volumetric, HollowBodyKeepsItsWall) {
  const Mesh mesh = HollowBall();
  const PointsX3 u = mesh.points * Eigen::Vector3d(1, 1, 1.8).asDiagonal();
  const VolumetricInterpolator solid(mesh.points, u, mesh.faces);
  EXPECT_EQ(solid.report().bodies, 1);
  EXPECT_LT(Gap(solid.At(0.5), mesh.points * Eigen::Vector3d(1, 1, std::sqrt(1.8)).asDiagonal()),
            1e-6);  // exact but for the inner points' fit
}

TEST(Volumetric, VerticesWithoutFacesGoStraight) {
  Mesh mesh = MakeIcosphere(1);
  mesh.points.conservativeResize(mesh.vertex_count() + 1, 3);
  mesh.points.bottomRows(1) << 5, 0, 0;
  PointsX3 u = mesh.points;
  u.bottomRows(1) << 5, 2, 0;
  const PointsX3 frame = VolumetricInterpolator(mesh.points, u, mesh.faces).At(0.25);
  EXPECT_LT((frame.bottomRows(1) - Eigen::RowVector3d(5, 0.5, 0)).norm(), 1e-12);
}

TEST(Volumetric, FillsTheOtherKeyWhereTheSmootherOneCrossesItself) {
  const Bar bar(0.1);
  PointsX3 rough = bar.mesh.points;  // with bumps the straight key is the less smooth one
  for (Eigen::Index i = 0; i < rough.rows(); ++i)
    rough.row(i).head<2>() *= 1 + 0.2 * std::sin(40 * rough(i, 2));
  const PointsX3 crossing = bar.Bent(2.3 * kPi);
  const VolumetricInterpolator solid(crossing, rough, bar.mesh.faces);
  EXPECT_EQ(solid.report().meshed_key, 1);
  EXPECT_THAT(solid.report().note, ::testing::HasSubstr("passes through itself"));
  EXPECT_TRUE(solid.At(0.5).allFinite());
}

TEST(Volumetric, WhereBothKeysCrossThemselvesThePlacesArePartedToFillThem) {
  // Two intersecting spikes, in both keys; one key is rotated and slightly longer.
  const Bar bar(0.15);
  PointsX3 v = bar.mesh.points;
  const int a = 14 * Bar::kSegments, b = 17 * Bar::kSegments;
  v.row(a) += Eigen::RowVector3d(0.1, 0, 0.12);
  v.row(b) += Eigen::RowVector3d(0.1, 0.01, -0.12);
  PointsX3 u = v * Turn(1, Eigen::Vector3d::UnitX()).transpose();
  u.col(2) *= 1.1;
  const VolumetricInterpolator solid(v, u, bar.mesh.faces);
  EXPECT_GT(solid.report().parted, 0);
  EXPECT_THAT(solid.report().note, ::testing::HasSubstr("passes through itself"));
  EXPECT_LT(Gap(solid.At(1e-10), v), 1e-8);
  EXPECT_LT(Gap(solid.At(1 - 1e-10), u), 1e-8);
  const PointsX3 exact = v * Turn(0.5, Eigen::Vector3d::UnitX()).transpose() *
                         Eigen::Vector3d(1, 1, std::sqrt(1.1)).asDiagonal();
  EXPECT_LT(MeanError(solid.At(0.5), exact), 0.01);
}

TEST(Volumetric, WhatNoPartingHelpsThrows) {
  const Bar bar(0.1);
  EXPECT_THAT(MessageOf([&] {
                VolumetricInterpolator(bar.Bent(2.3 * kPi), bar.Bent(2.5 * kPi), bar.mesh.faces);
              }),
              ::testing::HasSubstr("nor can the"));
}

TEST(Volumetric, TetrahedraThatTheSurfaceTurnsInsideOutAreCountedAndTheEndsStayExact) {
  const Mesh mesh = MakeIcosphere(1);
  PointsX3 u = mesh.points;
  u.row(0) = -1.5 * u.row(0);  // a vertex pushed out of the far side
  const VolumetricInterpolator solid(mesh.points, u, mesh.faces);
  EXPECT_GT(solid.report().inverted, 0);
  EXPECT_LT(Gap(solid.At(1 - 1e-10), u), 1e-8);
  EXPECT_TRUE(solid.At(0.5).allFinite());
}

TEST(Volumetric, SameBitsAtOneAndTwoThreads) {
  const Bar bar(0.2, true);
  const PointsX3 u = bar.Twisted(7);
  std::vector<PointsX3> frames;
  for (int threads : {1, 2}) {
    SetThreadCount(threads);
    frames.push_back(VolumetricInterpolator(bar.mesh.points, u, bar.mesh.faces).At(0.3));
  }
  SetThreadCount(0);
  EXPECT_TRUE(SameBits(frames[0], frames[1]));
}

TEST(Volumetric, KeysOfOtherSizesAndMirroredKeysThrow) {
  const Mesh mesh = MakeIcosphere(1);
  EXPECT_THROW(VolumetricInterpolator(mesh.points, mesh.points.topRows(5), mesh.faces), InputError);
  EXPECT_THAT(MessageOf([&] { VolumetricInterpolator(mesh.points, -mesh.points, mesh.faces); }),
              ::testing::HasSubstr("inside out"));
}

}  // namespace keypose::interpolation::volumetric_test
