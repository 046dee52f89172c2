#include "cleanup/editing/adapt.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

#include "cleanup/editing/decimate.h"
#include "cleanup/editing/size_field.h"
#include "cleanup/repair/intersections.h"
#include "cleanup/strategies/cleanup.h"
#include "cleanup/strategies/measure.h"
#include "cleanup/testing/damaged_meshes.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::cleanup::adapt_test {

/// Faces that the plane x = `at` runs through.
int FacesRound(const Mesh& mesh, double at) {
  int count = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    int above = 0;
    for (int k = 0; k < 3; ++k) above += mesh.points(mesh.faces(f, k), 0) > at;
    count += above == 1 || above == 2;
  }
  return count;
}

/// A sphere of radius 1 out of which a rod of radius 0.02 grows along x to 3: one surface.
Mesh BallWithThinLimb() {
  std::vector<Eigen::Vector2d> profile;  // radius and height, downwards
  for (int i = 0; i <= 150; ++i) profile.emplace_back(0.02, 3 - 2.0 * i / 150);
  for (int i = 1; i < 60; ++i)
    profile.emplace_back(std::sin(EIGEN_PI * i / 60), std::cos(EIGEN_PI * i / 60));
  Mesh mesh = MakeRevolved(profile, 32);
  mesh.points.col(0).swap(mesh.points.col(2));
  mesh.faces.col(1).swap(mesh.faces.col(2));
  return mesh;
}

TEST(MaxCurvature, IsOneOverTheRadius) {
  Mesh sphere = MakeIcosphere(4);
  sphere.points *= 0.5;
  const Eigen::VectorXd curvature = MaxCurvature(sphere);
  EXPECT_NEAR(curvature.mean(), 2, 0.1);
  EXPECT_NEAR(curvature.minCoeff(), 2, 0.4);  // fans of five faces
  EXPECT_NEAR(curvature.maxCoeff(), 2, 0.4);
  const Mesh rod = MakeCylinder(0.1, 2, 48, 60);
  const Eigen::VectorXd along = MaxCurvature(rod);
  for (int v = 0; v < 48 * 61; ++v)
    if (rod.points(v, 2) > 0.3 && rod.points(v, 2) < 1.7) {
      ASSERT_NEAR(along[v], 10, 0.5);
    }
}

TEST(Thickness, IsTheDiameterOfARod) {
  const Mesh rod = MakeCylinder(0.1, 2, 48, 60);
  const Eigen::VectorXd thickness = Thickness(rod);
  for (int v = 0; v < 48 * 61; ++v)
    if (rod.points(v, 2) > 0.3 && rod.points(v, 2) < 1.7) {
      ASSERT_NEAR(thickness[v], 0.2, 0.002);
    }
}

TEST(Remeshed, HitsTheCountWithGoodAnglesAndKeepsTheVolume) {
  const Mesh sphere = MakeIcosphere(5);
  for (const int faces : {500, 2000, 8000}) {
    SizeRules rules;
    rules.faces = faces;
    const Mesh mesh = Remeshed(sphere, sphere, EdgeSizes(sphere, rules), faces);
    EXPECT_TRUE(CheckClosed(mesh).closed());
    EXPECT_FALSE(SelfIntersects(mesh));
    EXPECT_NEAR(mesh.face_count(), faces, 1);
    EXPECT_GT(LeastAngleDeg(mesh), 20);
    const double volume = SignedVolume(sphere.points, sphere.faces);
    EXPECT_NEAR(SignedVolume(mesh.points, mesh.faces), volume, 0.003 * volume);
  }
}

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

TEST(Remeshed, FacesDoNotCutOffSharpEdges) {
  const Mesh box = SplitTo(MakeBox(1, 1, 1), 12000);
  SizeRules rules;
  rules.faces = 1500;
  const Mesh mesh = Remeshed(box, box, EdgeSizes(box, rules), rules.faces);
  EXPECT_TRUE(CheckClosed(mesh).closed());
  EXPECT_NEAR(mesh.face_count(), rules.faces, 15);
  EXPECT_NEAR(SignedVolume(mesh.points, mesh.faces), 1, 1e-3);
  CleanupResult distance;
  MeasureDistances(mesh, box, box, distance);
  // Edges are 0.09 long; those that run across the box's would leave 0.006 of the diagonal open in
  // the middle of many faces.
  EXPECT_LT(distance.from_input.p99, 0.001);
  EXPECT_LT(distance.to_input.p99, 0.001);
}

TEST(MakeClosedManifold, ThinLimbKeepsEightFacesRound) {
  for (const char* remesh : {"uniform", "adaptive"}) {
    CleanupOptions options;
    options.faces = 8000;
    options.remesh = remesh;
    const CleanupResult result = MakeClosedManifold(BallWithThinLimb(), options);
    EXPECT_NEAR(result.mesh.face_count(), 8000, 80);
    for (double x = 1.2; x < 2.95; x += 0.05)
      EXPECT_GE(FacesRound(result.mesh, x), 8) << remesh << " " << x;
    EXPECT_GT(result.mesh.points.col(0).maxCoeff(), 2.98) << remesh;
  }
}

TEST(Decimated, KeepsShapeTopologyAndBorder) {
  const Mesh torus = MakeTorus(1, 0.35, 120, 48);
  const Mesh coarse = Decimated(torus, 3000);
  EXPECT_LE(coarse.face_count(), 3000);
  EXPECT_GT(coarse.face_count(), 2900);
  EXPECT_EQ(CheckClosed(coarse).euler, 0);
  EXPECT_TRUE(CheckClosed(coarse).closed());
  const double volume = SignedVolume(torus.points, torus.faces);
  EXPECT_NEAR(SignedVolume(coarse.points, coarse.faces), volume, 0.003 * volume);
  CleanupResult distance;
  MeasureDistances(coarse, torus, torus, distance);
  EXPECT_LT(distance.from_input.max, 0.01);
  const Mesh bowl = Without(MakeIcosphere(5), {0}, 10);
  const Mesh coarse_bowl = Decimated(bowl, 4000);
  const auto border = [](const Mesh& mesh) {
    std::set<std::array<double, 3>> points;
    const std::vector<char> on = BoundaryVertices(mesh.vertex_count(), mesh.faces);
    for (int v = 0; v < mesh.vertex_count(); ++v)
      if (on[v]) points.insert({mesh.points(v, 0), mesh.points(v, 1), mesh.points(v, 2)});
    return points;
  };
  EXPECT_GE(border(bowl).size(), 30u);
  EXPECT_EQ(border(coarse_bowl), border(bowl));
}

TEST(Decimated, SameBitsForAnyThreadCount) {
  const Mesh mesh = MakeFigure(3, 3);
  SetThreadCount(1);
  const Mesh one = Decimated(mesh, 500);
  SetThreadCount(3);
  const Mesh three = Decimated(mesh, 500);
  SetThreadCount(0);
  EXPECT_EQ(one.points, three.points);
  EXPECT_EQ(one.faces, three.faces);
}

TEST(WithoutThinAngles, SliverOnABoxGoes) {
  Mesh box = SplitTo(MakeBox(1, 1, 1), 400);
  const Mesh better = WithoutThinAngles(box, 25);
  EXPECT_TRUE(CheckClosed(better).closed());
  EXPECT_GE(LeastAngleDeg(better), LeastAngleDeg(box));
  EXPECT_NEAR(SignedVolume(better.points, better.faces), 1, 1e-9);
}

TEST(SplitTo, KeepsTheSurfaceAndHitsTheCount) {
  const Mesh mesh = SplitTo(MakeBox(1, 1, 1), 1000);
  EXPECT_EQ(mesh.face_count(), 1000);
  EXPECT_TRUE(CheckClosed(mesh).closed());
  EXPECT_NEAR(SurfaceArea(mesh.points, mesh.faces), 6, 1e-12);
}

}  // namespace keypose::cleanup::adapt_test
