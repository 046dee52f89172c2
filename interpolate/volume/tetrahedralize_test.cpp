// Surfaces filled with tetrahedra, and inner points placed in them.
#include "interpolate/volume/tetrahedralize.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "interpolate/testing/bars.h"
#include "interpolate/volume/run_tetgen.h"
#include "interpolate/volume/tet_maps.h"

namespace keypose::interpolation::tetrahedralize_test {

double SolidVolume(const Solid& solid) {
  double sum = 0;
  for (const TetShape& shape : TetShapesOf(solid.points, solid.tets)) sum += shape.volume;
  return sum;
}

TEST(Tetrahedralize, FillsTheSurfaceAndKeepsItsVertices) {
  for (const Mesh& mesh : {MakeBox(1, 2, 3), MakeIcosphere(3), Bar(0.2, true).mesh, HollowBall()}) {
    const Solid solid = Tetrahedralize(mesh.points, mesh.faces, "test");
    EXPECT_TRUE(SameBits(solid.points.topRows(mesh.vertex_count()), mesh.points));
    EXPECT_NEAR(SolidVolume(solid), SignedVolume(mesh.points, mesh.faces),
                1e-12 * BoundingDiagonal(mesh.points));
    for (const TetShape& shape : TetShapesOf(solid.points, solid.tets)) EXPECT_GT(shape.volume, 0);
    for (Eigen::Index t = 0; t < solid.tets.rows(); ++t)
      for (int n : solid.opposite[t])
        if (n >= 0) {
          EXPECT_THAT(solid.opposite[n], ::testing::Contains(static_cast<int>(t)));
        }
  }
}

TEST(Tetrahedralize, BodiesThatOverlapAreFilledEachForItself) {
  Mesh mesh = MakeIcosphere(2), eye = MakeIcosphere(1);
  eye.points *= 0.3;
  eye.points.rowwise() += Eigen::RowVector3d(1, 0, 0);
  Join(mesh, eye);
  const Solid solid = Tetrahedralize(mesh.points, mesh.faces, "test");
  EXPECT_EQ(solid.bodies, 2);
  EXPECT_NEAR(SolidVolume(solid), SignedVolume(mesh.points, mesh.faces), 1e-12);
}

TEST(Tetrahedralize, SmallerElementsGiveMoreTetrahedraUpToTheLimit) {
  const Mesh mesh = MakeIcosphere(3);
  const auto count = [&](double size, int most) {
    return Tetrahedralize(mesh.points, mesh.faces, "test",
                          {.element_size = size, .max_tetrahedra = most})
        .tets.rows();
  };
  EXPECT_GT(count(0.5, 50000), 2 * count(1, 50000));
  EXPECT_LT(count(0.2, 20000), 40000);
}

TEST(RunTetgen, IsEndedWhereItTakesTooLong) {
  const Mesh box = MakeBox(1, 1, 1);
  const auto run = [&](const std::string& largest) {
    return RunTetgen(box.points, box.faces, "pq1.4nzQa" + largest, 1);
  };
  EXPECT_TRUE(run("0.01"));
  EXPECT_FALSE(run("0.0000001"));  // tens of millions of tetrahedra
}

TEST(Tetrahedralize, NamesWhatKeepsASurfaceFromBeingFilled) {
  const auto fault = [](const Mesh& mesh) {
    return MessageOf([&] { Tetrahedralize(mesh.points, mesh.faces, "pose"); });
  };
  Mesh open = MakeBox(1, 1, 1);
  open.faces.conservativeResize(11, 3);
  EXPECT_THAT(fault(open),
              ::testing::AllOf(::testing::HasSubstr("pose: the surface is not closed: 3 edges"),
                               ::testing::HasSubstr("keypose-cleanup")));
  Mesh flat = MakeBox(1, 1, 1);
  flat.points.row(0) = flat.points.row(1);
  EXPECT_THAT(fault(flat), ::testing::HasSubstr("has no area"));
  Mesh inside_out = MakeBox(1, 1, 1);
  inside_out.faces.col(1).swap(inside_out.faces.col(2));
  EXPECT_THAT(fault(inside_out), ::testing::HasSubstr("inside out"));
  Mesh crossing = Bar(0.1).mesh;  // curled up, intersecting itself
  crossing.points = Bar(0.1).Bent(2.3 * kPi);
  EXPECT_THAT(fault(crossing),
              ::testing::HasSubstr("passes through itself, where the face of vertices"));
}

}  // namespace keypose::interpolation::tetrahedralize_test
