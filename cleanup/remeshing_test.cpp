#include <gtest/gtest.h>

#include <array>
#include <set>

#include "cleanup/editing/adapt.h"
#include "cleanup/editing/decimate.h"
#include "cleanup/editing/size_field.h"
#include "cleanup/repair/intersections.h"
#include "cleanup/strategies/measure.h"
#include "cleanup/testing/damaged_meshes.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::cleanup::remeshing_test {

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

TEST(WithoutThinAngles, SliverOnABoxGoes) {
  Mesh box = SplitTo(MakeBox(1, 1, 1), 400);
  const Mesh better = WithoutThinAngles(box, 25);
  EXPECT_TRUE(CheckClosed(better).closed());
  EXPECT_GE(LeastAngleDeg(better), LeastAngleDeg(box));
  EXPECT_NEAR(SignedVolume(better.points, better.faces), 1, 1e-9);
}

}  // namespace keypose::cleanup::remeshing_test
