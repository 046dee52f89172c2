#include "reconstruct/meshing/surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "reconstruct/meshing/testing/sphere_cloud.h"

namespace keypose::reconstruct::surface_test {

double LargestRadiusError(const Mesh& mesh) {
  return ((mesh.points.rowwise() - kCenter).rowwise().norm().array() - kRadius).abs().maxCoeff();
}

MeshOptions Fast() {
  MeshOptions options;
  options.max_depth = 7;
  return options;
}

SurfaceResult Reconstruct(const PointCloud& cloud, const MeshOptions& options = Fast()) {
  return ReconstructSurface(cloud, options, "cloud.ply", nullptr);
}

TEST(ReconstructSurface, PointsBeyondTheMeshsFinenessAreMerged) {
  MeshOptions options;
  options.max_depth = 6;
  const SurfaceResult dense = ReconstructSurface(SphereCloud(160000), options, "cloud", nullptr);
  // A surface meets 1.5 cells of a cubic grid for each cell's face of area, averaged over
  // directions; octants of normals add a few.
  const double cell = options.merge * kPoissonCubeScale * 2 * kRadius * 0.98 / 64;
  const double cells = 1.5 * 4 * std::numbers::pi * kRadius * kRadius / (cell * cell);
  EXPECT_NEAR(static_cast<double>(dense.used.cloud.points.rows()), cells, 0.2 * cells);
  EXPECT_LT(LargestRadiusError(dense.mesh), 0.01 * kRadius);
}

TEST(ReconstructSurface, AStrayDoesNotMakeTheMeshCoarse) {
  PointCloud cloud = SphereCloud(20000);
  cloud.points.row(0) *= 1e4;
  const SurfaceResult result = ReconstructSurface(cloud, {}, "cloud", nullptr);
  EXPECT_GT(result.used.cloud.points.rows(), 15000);
  EXPECT_LT(LargestRadiusError(result.mesh), 0.01 * kRadius);
}

TEST(ReconstructSurface, SphereCloudGivesClosedOutwardSphereWithinSpacing) {
  const auto result = Reconstruct(SphereCloud(8000));
  EXPECT_LT(LargestRadiusError(result.mesh),
            0.01 * kRadius);  // cells of depth 6 are 0.034 radii wide
  const ClosedReport closed = CheckClosed(result.mesh);
  EXPECT_EQ(closed.bad_edges, 0);
  EXPECT_EQ(closed.components, 1);
  EXPECT_NEAR(closed.volume, 4.0 / 3 * std::numbers::pi * std::pow(kRadius, 3),
              0.005 * closed.volume);
  EXPECT_EQ(result.trimmed_faces, 0);
  EXPECT_EQ(
      result.used.removed_outliers + result.used.removed_contrary + result.used.removed_unsure, 0);
}

TEST(ReconstructSurface, SpacingOfEvenSamplesIsRootOfAreaPerPoint) {
  const auto result = Reconstruct(SphereCloud(8000));
  const double expected = std::sqrt(4 * std::numbers::pi * kRadius * kRadius / 8000);
  EXPECT_NEAR(result.used.median_spacing, expected, 0.1 * expected);
  EXPECT_EQ(result.depth, DepthForSampling(2 * std::sqrt(3.0) * kRadius, expected, 7));
}

TEST(ReconstructSurface, HemisphereIsTrimmedWhereThereIsNoData) {
  const auto result = Reconstruct(UpperCap(SphereCloud(8000), 0));
  EXPECT_GT(result.trimmed_faces, 100);
  EXPECT_FALSE(CheckClosed(result.mesh).closed());
  const double reach =
      Fast().trim.trim * std::max(result.used.median_spacing,
                                  kPoissonCubeScale * 2 * kRadius / std::pow(2.0, result.depth));
  EXPECT_GT(result.mesh.points.col(2).minCoeff(), kCenter.z() - 1.5 * reach);
  EXPECT_NEAR(result.mesh.points.col(2).maxCoeff(), kCenter.z() + kRadius, 0.05);
}

TEST(ReconstructSurface, GenerousTrimKeepsTheSmoothClosure) {
  MeshOptions options = Fast();
  options.trim.trim = 0;
  const auto result = Reconstruct(UpperCap(SphereCloud(8000), -0.95), options);
  EXPECT_EQ(result.trimmed_faces, 0);
  EXPECT_EQ(CheckClosed(result.mesh).bad_edges, 0);
}

TEST(ReconstructSurface, SmallGapIsClosedAndCounted) {
  // The opening has 0.3 % of the sphere's area; it is trimmed at one spacing, and kept as a
  // closure.
  MeshOptions options = Fast();
  options.trim.trim = 1;
  options.trim.keep_area = 0.01;
  const auto result = Reconstruct(UpperCap(SphereCloud(8000), -0.994), options);
  EXPECT_EQ(CheckClosed(result.mesh).bad_edges, 0);
  EXPECT_GE(result.kept_closures, 1);
  EXPECT_EQ(result.trimmed_faces, 0);
}

TEST(ReconstructSurface, ColoursComeFromTheNearestPoints) {
  const auto result = Reconstruct(SphereCloud(8000));
  ASSERT_EQ(result.mesh.colors.rows(), result.mesh.vertex_count());
  int checked = 0;
  for (int v = 0; v < result.mesh.vertex_count(); ++v) {
    const double height = result.mesh.points(v, 2) - kCenter.z();
    if (std::abs(height) < 4 * result.used.median_spacing) continue;
    ++checked;
    ASSERT_EQ(result.mesh.colors(v, 0), height > 0 ? 220 : 10)
        << "vertex " << v << " at height " << height;
    ASSERT_EQ(result.mesh.colors(v, 2), height > 0 ? 10 : 220);
  }
  EXPECT_GT(checked, result.mesh.vertex_count() / 2);
}

TEST(ReconstructSurface, CloudWithoutColoursGivesMeshWithoutColours) {
  PointCloud cloud = SphereCloud(2000);
  cloud.colors.resize(0, 3);
  EXPECT_EQ(Reconstruct(cloud).mesh.colors.rows(), 0);
}

TEST(ReconstructSurface, LonelyPointsAreRemovedBeforeTheFit) {
  PointCloud strays = Rows(SphereCloud(20), {0, 4, 9, 15, 19});
  strays.points = (3 * (strays.points.rowwise() - kCenter)).rowwise() + kCenter;
  const auto result = Reconstruct(Joined(SphereCloud(8000), strays));
  EXPECT_EQ(result.used.removed_outliers, 5);
  EXPECT_LT(LargestRadiusError(result.mesh), 0.01 * kRadius);
}

TEST(ReconstructSurface, SmallFloatingBlobIsRemoved) {
  PointCloud blob = SphereCloud(200);
  blob.points = (0.15 * (blob.points.rowwise() - kCenter)).rowwise() +
                (kCenter + Eigen::RowVector3d(9, 0, 0));
  MeshOptions options = Fast();
  options.trim.min_component = 0.1;
  const auto result = Reconstruct(Joined(SphereCloud(8000), blob), options);
  EXPECT_EQ(CheckClosed(result.mesh).components, 1);
  EXPECT_GE(result.removed_components, 1);
  EXPECT_LT(LargestRadiusError(result.mesh), 0.02 * kRadius);
}

TEST(ReconstructSurface, ContraryNormalsAreDropped) {
  PointCloud cloud = SphereCloud(8000);
  for (int i = 100; i < 8000; i += 400) cloud.normals.row(i) *= -1;
  const auto result = Reconstruct(cloud);
  EXPECT_EQ(result.used.removed_contrary, 20);
  EXPECT_LT(LargestRadiusError(result.mesh), 0.01 * kRadius);
}

TEST(ReconstructSurface, InwardNormalsAreTurnedAndReported) {
  PointCloud cloud = SphereCloud(4000);
  cloud.normals *= -1;
  const auto result = Reconstruct(cloud);
  EXPECT_TRUE(result.used.normals_flipped);
  EXPECT_GT(SignedVolume(result.mesh.points, result.mesh.faces), 0);
}

TEST(ReconstructSurface, MoreSamplesANodeGiveACoarserMesh) {
  const PointCloud cloud = SphereCloud(4000);
  MeshOptions few = Fast(), many = Fast();
  few.depth = many.depth = 7;
  few.poisson.samples_per_node = 1;
  many.poisson.samples_per_node = 50;
  EXPECT_LT(Reconstruct(cloud, many).mesh.face_count(),
            0.7 * Reconstruct(cloud, few).mesh.face_count());
}

TEST(ReconstructSurface, UnsurePointsAreLeftOut) {
  PointCloud cloud = SphereCloud(4000);
  cloud.confidence = Eigen::VectorXf::Ones(4000);
  cloud.confidence.head(10).setConstant(0.1f);
  MeshOptions options = Fast();
  options.filter.min_confidence = 0.5;
  EXPECT_EQ(Reconstruct(cloud, options).used.removed_unsure, 10);
}

TEST(ReconstructSurface, SameBitsForAnyThreadCount) {
  SetThreadCount(1);
  const auto one = Reconstruct(SphereCloud(4000));
  SetThreadCount(3);
  const auto three = Reconstruct(SphereCloud(4000));
  SetThreadCount(0);
  EXPECT_EQ(one.mesh.points, three.mesh.points);
  EXPECT_EQ(one.mesh.faces, three.mesh.faces);
  EXPECT_EQ(one.mesh.colors, three.mesh.colors);
}

// Mean height above the sphere, in radii, of the surface near the pole.
double PoleHeight(const Mesh& mesh) {
  double sum = 0;
  int count = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Eigen::RowVector3d x = (mesh.points.row(v) - kCenter) / kRadius;
    if (x.normalized().z() < 0.99) continue;
    sum += x.norm() - 1, ++count;
  }
  return sum / std::max(1, count);
}

TEST(ReconstructSurface, WrongPatchOfLowConfidenceMovesTheSurfaceLessThanATenthOfASureOne) {
  const PointCloud sphere = SphereCloud(8000);
  PointCloud patch = UpperCap(SphereCloud(7000), 0.95);  // as dense as the correct points
  patch.points += 0.04 * kRadius * patch.normals;
  PointCloud both = Joined(sphere, patch);
  both.confidence = Eigen::VectorXf::Ones(both.points.rows());
  const double sure = PoleHeight(Reconstruct(both).mesh);
  both.confidence.tail(patch.points.rows()).setConstant(0.1f);
  const double unsure = PoleHeight(Reconstruct(both).mesh);
  EXPECT_GT(sure, 0.01);
  EXPECT_LT(std::abs(unsure), 0.1 * sure);
}

TEST(ReconstructSurface, LowConfidenceHoldsTheSurfaceWhereNothingElseIs) {
  PointCloud cloud = SphereCloud(8000);
  cloud.confidence = Eigen::VectorXf::Ones(8000);
  for (int i = 0; i < 8000; ++i)
    if (cloud.normals(i, 2) > 0.7) cloud.confidence[i] = 0.1f;
  const auto result = Reconstruct(cloud);
  EXPECT_LT(LargestRadiusError(result.mesh), 0.015 * kRadius);
  EXPECT_TRUE(CheckClosed(result.mesh).closed());
}

TEST(ReconstructSurface, FarFromTheOriginTheShapeIsTheSame) {
  PointCloud far = SphereCloud(4000);
  far.points.rowwise() += Eigen::RowVector3d(1e5, -2e5, 3e4);
  const auto moved = Reconstruct(far);
  EXPECT_LT(((moved.mesh.points.rowwise() - (kCenter + Eigen::RowVector3d(1e5, -2e5, 3e4)))
                 .rowwise()
                 .norm()
                 .array() -
             kRadius)
                .abs()
                .maxCoeff(),
            0.02 * kRadius);
}

void ExpectInputError(const PointCloud& cloud, const std::string& part) {
  try {
    Reconstruct(cloud);
    FAIL() << "no error; expected one that says '" << part << "'";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr(part));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("cloud.ply"));
  }
}

TEST(ReconstructSurface, TooFewPointsThrowInputError) {
  ExpectInputError(SphereCloud(99), "99 points");
}

TEST(ReconstructSurface, CloudWithoutNormalsThrowsInputError) {
  PointCloud cloud = SphereCloud(500);
  cloud.normals.resize(0, 3);
  ExpectInputError(cloud, "no normals");
}

TEST(ReconstructSurface, NanPointThrowsInputErrorThatNamesIt) {
  PointCloud cloud = SphereCloud(500);
  cloud.points(123, 1) = NAN;
  ExpectInputError(cloud, "point 123");
}

TEST(ReconstructSurface, PointsInOnePlaceThrowInputError) {
  PointCloud cloud = SphereCloud(500);
  cloud.points.rowwise() = kCenter;
  ExpectInputError(cloud, "in one place");
}

TEST(ReconstructSurface, ZeroNormalsThrowInputErrorWhenTooFewAreLeft) {
  PointCloud cloud = SphereCloud(500);
  cloud.normals.bottomRows(450).setZero();
  ExpectInputError(cloud, "only 50 are left");
}

TEST(DepthForSampling, HalvingTheSpacingAddsOneLevelUpToTheCap) {
  EXPECT_EQ(DepthForSampling(100, 0.2, 12), 8);
  EXPECT_EQ(DepthForSampling(100, 0.1, 12), 9);
  EXPECT_EQ(DepthForSampling(100, 0.1, 7), 7);
  EXPECT_EQ(DepthForSampling(100, 50, 12), 4);
}

}  // namespace keypose::reconstruct::surface_test
