#include "reconstruct/refinement/refine_surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/errors.h"
#include "reconstruct/refinement/testing/wavy_surface.h"
#include "reconstruct/testing/rendered_ring.h"

namespace keypose::reconstruct::refine_surface_test {

using testing::RenderedScene;
using testing::RenderRing;

RefineOptions Options() {
  RefineOptions options;
  options.levels = kLevels;
  return options;
}

// Distances to the true surface in footprints, for the part that the rings see well.
std::vector<double> Errors(const RenderedScene& scene, const Mesh& mesh) {
  const RayScene rays(scene.truth.points, scene.truth.faces);
  std::vector<double> errors;
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v)
    if (mesh.points(v, 2) > -0.3)
      errors.push_back(std::sqrt(rays.ClosestPoint(mesh.points.row(v)).squared_distance) /
                       scene.footprint);
  return errors;
}

TEST(RefineSurface, TextureBringsAWavySurfaceBack) {
  const Mesh start = Wavy(Painted(), 1.5);
  const RefineResult result = RefineSurface(start, Views(Painted()), Options());
  const std::vector<double> before = Errors(Painted(), start),
                            after = Errors(Painted(), result.mesh);
  EXPECT_GT(QuantileFloor(before, 0.5), 0.7);
  EXPECT_LT(QuantileFloor(after, 0.5), 0.2)
      << "half a sampling step of the finest level, and less by the parabola";
  EXPECT_LT(QuantileFloor(after, 0.9), 0.6);
  EXPECT_LT(result.cost_after, 0.6 * result.cost_before);
  EXPECT_GT(result.seen, 0.7);
  EXPECT_GT(result.evidence, 0.6);
}

TEST(RefineSurface, ARoughSurfaceFarInsideOfTheOutlinesComesOutWithoutFolds) {
  const RenderedScene plain = RenderRing({.views = 9, .contrast = 0});
  Mesh start = Wavy(plain, 0);
  const PointsX3 normals = VertexNormals(start.points, start.faces);
  for (Eigen::Index v = 0; v < start.points.rows(); ++v) {
    const Eigen::RowVector3d x = start.points.row(v);
    const double bump = std::sin(32 * x.x()) * std::sin(32 * x.y()) * std::sin(32 * x.z());
    start.points.row(v) -= plain.footprint * (5 + 3 * bump) * normals.row(v);
  }
  RefineOptions options = Options();
  options.normal_reach = 3;
  const RefineResult result = RefineSurface(start, Views(plain), options);
  EXPECT_GT(result.outline_gap_before_px, 2);
  EXPECT_LT(result.outline_gap_px, 0.5 * result.outline_gap_before_px);
  const PointsX3 truth = FaceNormals(Wavy(plain, 0).points, start.faces),
                 is = FaceNormals(result.mesh.points, start.faces);
  std::vector<double> turns;
  for (Eigen::Index f = 0; f < is.rows(); ++f)
    turns.push_back(std::acos(std::clamp(truth.row(f).dot(is.row(f)), -1.0, 1.0)) * 180 / M_PI);
  std::sort(turns.begin(), turns.end());
  EXPECT_LT(QuantileFloor(turns, 0.95), 20) << "along normals of its own bumps it is 89";
  EXPECT_LT(QuantileFloor(Errors(plain, result.mesh), 0.9), 2);
  EXPECT_LT(result.unfolded, 200) << "12,000 else";
}

TEST(RefineSurface, EachWeightMovesTheResultTheWayItSays) {
  const Mesh start = Wavy(Painted(), 1.5);
  const std::vector<PreparedView> views = Views(Painted());
  const auto moved = [&](const RefineOptions& options) {
    const Mesh mesh = RefineSurface(start, views, options).mesh;
    return (mesh.points - start.points).rowwise().norm().mean();
  };
  const double plain = moved(Options());
  RefineOptions options = Options();
  options.anchor = 100;
  EXPECT_LT(moved(options), 0.5 * plain) << "vertices are held in place";
  options = Options();
  options.membrane = 100;
  EXPECT_LT(moved(options), 0.9 * plain) << "waves cannot follow equal displacements";
  options = Options();
  options.rounds = 1;
  EXPECT_LT(moved(options), plain) << "one search reaches less far than three";
  options = Options();
  options.violations = 0;
  EXPECT_NE(moved(options), plain) << "the waves stick out of the masks";
}

TEST(RefineSurface, FacesAndColoursStay) {
  Mesh start = Wavy(Painted(), 0.5);
  start.colors = ColorsX3::Constant(start.vertex_count(), 3, 90);
  const RefineResult result = RefineSurface(start, Views(Painted()), Options());
  EXPECT_EQ(result.mesh.faces, start.faces);
  EXPECT_EQ(result.mesh.colors, start.colors);
  EXPECT_TRUE(CheckClosed(result.mesh).closed());
}

TEST(RefineSurface, WithoutTextureTheSurfaceStaysSmooth) {
  const RenderedScene plain = RenderRing({.views = 9, .contrast = 0, .shaded = true});
  const Mesh start = Wavy(plain, 0.5);
  const RefineResult result = RefineSurface(start, Views(plain), Options());
  const std::vector<double> before = Errors(plain, start), after = Errors(plain, result.mesh);
  EXPECT_LT(QuantileFloor(after, 0.5), QuantileFloor(before, 0.5) + 0.1);
  EXPECT_LT(QuantileFloor(after, 0.95), QuantileFloor(before, 0.95) + 0.3);
  const PointsX3 was = FaceNormals(start.points, start.faces),
                 is = FaceNormals(result.mesh.points, result.mesh.faces);
  std::vector<double> turns;
  for (Eigen::Index f = 0; f < was.rows(); ++f)
    turns.push_back(std::acos(std::clamp(was.row(f).dot(is.row(f)), -1.0, 1.0)) * 180 / M_PI);
  std::sort(turns.begin(), turns.end());
  EXPECT_LT(QuantileFloor(turns, 0.95), 18) << "noise does not make it rough";
}

TEST(RefineSurface, SameBitsWithOneThreadAndTwo) {
  const Mesh start = Wavy(Painted(), 1);
  SetThreadCount(1);
  const RefineResult one = RefineSurface(start, Views(Painted()), Options());
  SetThreadCount(2);
  const RefineResult two = RefineSurface(start, Views(Painted()), Options());
  SetThreadCount(0);
  EXPECT_EQ(one.mesh.points, two.mesh.points);
}

TEST(RefineSurface, ASurfaceOfAnotherPlaceIsRefused) {
  Mesh elsewhere = Wavy(Painted(), 0);
  elsewhere.points.rowwise() += Eigen::RowVector3d(40, 0, 0);
  try {
    RefineSurface(elsewhere, Views(Painted()), Options());
    FAIL() << "no photograph shows this surface";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("other photographs or cameras"));
  }
}

TEST(RefineSurface, AMeshWithoutFacesIsRefused) {
  Mesh points = Wavy(Painted(), 0);
  points.faces.resize(0, 3);
  EXPECT_THROW(RefineSurface(points, Views(Painted()), Options()), InputError);
}

}  // namespace keypose::reconstruct::refine_surface_test
