#include "reconstruct/refinement/refine_surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "reconstruct/refinement/displacement_solve.h"
#include "reconstruct/refinement/photo_profile.h"
#include "reconstruct/testing/rendered_ring.h"

namespace keypose::reconstruct::refine_test {

using testing::Prepared;
using testing::RenderedScene;
using testing::RenderRing;
using testing::RingOptions;

constexpr int kLevels = 2;

RefineOptions Options() {
  RefineOptions options;
  options.levels = kLevels;
  return options;
}

std::vector<PreparedView> Views(const RenderedScene& scene) { return Prepared(scene, kLevels); }

const RenderedScene& Painted() {
  static const RenderedScene scene = RenderRing({.views = 9});
  return scene;
}

// The true surface, displaced along its normals by smooth waves of `footprints`; vertices about two
// pixels apart.
Mesh Wavy(const RenderedScene& scene, double footprints) {
  Mesh mesh = MakeIcosphere(5);
  const RayScene rays(scene.truth.points, scene.truth.faces);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Eigen::Vector3d way = mesh.points.row(v).normalized();
    mesh.points.row(v) = rays.Cast(3 * way, -way).distance * -way + 3 * way;
  }
  const PointsX3 normals = VertexNormals(mesh.points, mesh.faces);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Eigen::Vector3d x = mesh.points.row(v);
    const double wave =
        std::sin(7 * x.x() + 1) * std::sin(6 * x.y() - 2) + std::sin(5 * x.z() + 3 * x.x());
    mesh.points.row(v) += footprints * scene.footprint * wave * normals.row(v);
  }
  return mesh;
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

TEST(CostProfiles, TheLeastCostIsAtTheTrueSurface) {
  const std::vector<PreparedView> views = Views(Painted());
  const Mesh mesh = Wavy(Painted(), 0);
  const PointsX3 normals = VertexNormals(mesh.points, mesh.faces);
  const std::vector<VertexViews> chosen =
      ChooseViews(mesh.points, views, AllSights(mesh, normals, views));
  const Profiles profiles =
      CostProfiles(mesh.points, normals, chosen, views, 0, 8, 0.5 * Painted().footprint);
  int compared = 0, central = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const float* row = profiles.Row(v);
    const int least = static_cast<int>(std::min_element(row, row + profiles.count()) - row);
    if (row[least] >= 0.3f) continue;
    ++compared, central += std::abs(least - profiles.steps) <= 1;
  }
  EXPECT_GT(compared, mesh.vertex_count() / 2);
  EXPECT_GT(central, 0.95 * compared);
}

TEST(CostProfiles, VectorCodeMeasuresWhatPlainLoopsMeasure) {
  const std::vector<PreparedView> views = Views(Painted());
  const Mesh mesh = Wavy(Painted(), 1);
  const PointsX3 normals = VertexNormals(mesh.points, mesh.faces);
  const std::vector<VertexViews> chosen =
      ChooseViews(mesh.points, views, AllSights(mesh, normals, views));
  const Profiles fast =
      CostProfiles(mesh.points, normals, chosen, views, 1, 3, Painted().footprint);
  const Profiles plain =
      CostProfilesPlain(mesh.points, normals, chosen, views, 1, 3, Painted().footprint);
  float largest = 0;
  for (std::size_t i = 0; i < fast.cost.size(); ++i)
    largest = std::max(largest, std::abs(fast.cost[i] - plain.cost[i]));
  EXPECT_LT(largest, 1e-4f);
}

TEST(SolveDisplacement, StrongDataAreMet) {
  const Mesh ball = MakeIcosphere(3);
  const Neighbors neighbors = MakeNeighbors(ball.points, ball.faces);
  DisplacementEnergy energy{neighbors.mean_edge, 0.02, 1, 1e-4, {}, {}, {}, {}};
  energy.target.assign(ball.vertex_count(), 0.7f), energy.weight.assign(ball.vertex_count(), 1e4f);
  std::vector<float> shift(ball.vertex_count(), 0.0f);
  SolveDisplacement(ball.points, ball.points, neighbors, energy, &shift);
  for (const float d : shift) EXPECT_NEAR(d, 0.7f, 1e-3f);
}

TEST(SolveDisplacement, WithoutDataNoiseIsSmoothedAway) {
  Mesh ball = MakeIcosphere(4);
  const Neighbors neighbors = MakeNeighbors(ball.points, ball.faces);
  const PointsX3 normals = ball.points;
  for (int v = 0; v < ball.vertex_count(); ++v)
    ball.points.row(v) *= 1 + 0.01 * std::sin(12.9898 * v);
  DisplacementEnergy energy{neighbors.mean_edge, 0.02, 10, 1e-4, {}, {}, {}, {}};
  energy.target.assign(ball.vertex_count(), 0.0f), energy.weight.assign(ball.vertex_count(), 0.0f);
  std::vector<float> shift(ball.vertex_count(), 0.0f);
  SolveDisplacement(ball.points, normals, neighbors, energy, &shift);
  double before = 0, after = 0;
  for (int v = 0; v < ball.vertex_count(); ++v) {
    before += std::pow(ball.points.row(v).norm() - 1, 2);
    after += std::pow(
        (ball.points.row(v) + shift[v] * neighbors.mean_edge * normals.row(v)).norm() - 1, 2);
  }
  EXPECT_LT(after, 0.25 * before);
}

TEST(Diffuse, VerticesThatKnowNothingTakeFromTheOthers) {
  const Mesh ball = MakeIcosphere(2);
  const Neighbors neighbors = MakeNeighbors(ball.points, ball.faces);
  std::vector<char> known(ball.vertex_count(), 1);
  std::vector<float> values(ball.vertex_count(), 3.0f);
  known[5] = 0, values[5] = 100;
  Diffuse(neighbors, 1, 1, known, &values);
  for (const float value : values) EXPECT_NEAR(value, 3, 1e-5f);
}

}  // namespace keypose::reconstruct::refine_test
