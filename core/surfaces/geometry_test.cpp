#include "core/surfaces/geometry.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/surfaces/shapes.h"
#include "core/values/same_faces.h"

namespace keypose::geometry_test {

TEST(Geometry, BoxHasItsAreaVolumeAndDiagonal) {
  const Mesh box = MakeBox(1, 2, 3);
  EXPECT_NEAR(SurfaceArea(box.points, box.faces), 22, 1e-12);
  EXPECT_NEAR(SignedVolume(box.points, box.faces), 6, 1e-12);
  EXPECT_NEAR(BoundingDiagonal(box.points), std::sqrt(14.0), 1e-12);
}

TEST(Geometry, FacesAreTheSameOnlyWithEqualNumbersAndOrder) {
  const Mesh box = MakeBox(1, 2, 3);
  EXPECT_TRUE(SameFaces(box.faces, MakeBox(3, 2, 1).faces));
  const FacesX3 fewer = box.faces.topRows(box.faces.rows() - 1);
  EXPECT_FALSE(SameFaces(box.faces, fewer));
  EXPECT_FALSE(SameFaces(fewer, box.faces));
  FacesX3 swapped = box.faces;
  swapped.row(0).swap(swapped.row(1));
  EXPECT_FALSE(SameFaces(box.faces, swapped));
}

TEST(Geometry, VerticesHaveAThirdOfTheirFacesAreas) {
  PointsX3 points(5, 3);
  points << 0, 0, 0, 3, 0, 0, 3, 2, 0, 0, 2, 0, 7, 7, 7;
  FacesX3 faces(2, 3);
  faces << 0, 1, 2, 0, 2, 3;  // each has the area 3
  const Eigen::VectorXd areas = VertexAreas(points, faces);
  EXPECT_EQ(areas, (Eigen::VectorXd(5) << 2, 1, 2, 1, 0).finished());
}

TEST(Geometry, VolumeOfAFarAwayMeshKeepsItsDigits) {
  Mesh box = MakeBox(1, 1, 1);
  box.points.rowwise() += Eigen::RowVector3d(1e6, -1e6, 1e6);
  EXPECT_NEAR(SignedVolume(box.points, box.faces), 1, 1e-9);
}

TEST(Geometry, SphereNormalsPointOutwards) {
  const Mesh sphere = MakeIcosphere(3);
  const PointsX3 normals = VertexNormals(sphere.points, sphere.faces);
  for (Eigen::Index v = 0; v < normals.rows(); ++v)
    EXPECT_GT(normals.row(v).dot(sphere.points.row(v)), 0.999);
}

TEST(CheckClosed, SphereAndCylinderAreClosed) {
  for (const Mesh& mesh : {MakeIcosphere(2), MakeCylinder(1, 4, 16, 10), MakeBox(1, 1, 1)}) {
    const ClosedReport report = CheckClosed(mesh);
    EXPECT_TRUE(report.closed());
    EXPECT_EQ(report.euler, 2);
    EXPECT_EQ(report.components, 1);
  }
}

TEST(CheckClosed, CountsEachDefect) {
  Mesh open = MakeIcosphere(2);
  open.faces = FacesX3(open.faces.topRows(open.faces.rows() - 1));
  EXPECT_EQ(CheckClosed(open).bad_edges, 3);
  EXPECT_EQ(CheckClosed(open).bad_fans, 3);

  Mesh flipped = MakeIcosphere(2);
  std::swap(flipped.faces(5, 0), flipped.faces(5, 1));
  EXPECT_GT(CheckClosed(flipped).bad_edges, 0);

  Mesh inside_out = MakeIcosphere(2);
  inside_out.faces.col(0).swap(inside_out.faces.col(1));
  EXPECT_FALSE(CheckClosed(inside_out).closed());
  EXPECT_LT(CheckClosed(inside_out).volume, 0);

  Mesh loose = MakeIcosphere(1);
  loose.points.conservativeResize(loose.points.rows() + 1, 3);
  loose.points.bottomRows(1).setZero();
  EXPECT_EQ(CheckClosed(loose).unused_vertices, 1);
}

TEST(BoundaryVertices, AreThoseRoundTheHole) {
  Mesh open = MakeIcosphere(2);
  const Eigen::RowVector3i removed = open.faces.bottomRows(1);
  open.faces = FacesX3(open.faces.topRows(open.faces.rows() - 1));
  const auto boundary = BoundaryVertices(open.vertex_count(), open.faces);
  EXPECT_EQ(std::count(boundary.begin(), boundary.end(), 1), 3);
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(boundary[removed(k)]);
}

TEST(SampleSurface, IsUniformByArea) {
  const Mesh box = MakeBox(1, 1, 3);
  const SurfaceSamples samples = SampleSurface(box.points, box.faces, 20000, 7);
  int on_top = 0;
  for (Eigen::Index i = 0; i < samples.points.rows(); ++i)
    on_top += samples.points(i, 2) > 3 - 1e-9;
  EXPECT_NEAR(on_top / 20000.0, 1.0 / 14, 0.01);  // five standard deviations
}

}  // namespace keypose::geometry_test
