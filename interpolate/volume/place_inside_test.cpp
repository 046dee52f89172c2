#include "interpolate/volume/place_inside.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "core/surfaces/shapes.h"
#include "interpolate/testing/bars.h"
#include "interpolate/volume/tet_maps.h"
#include "interpolate/volume/tetrahedralize.h"

namespace keypose::interpolation::place_inside_test {

TEST(PlaceInside, UntanglesInnerPointsThatWerePushedThroughTheirNeighbours) {
  const Mesh mesh = MakeIcosphere(2);
  const Solid solid = Tetrahedralize(mesh.points, mesh.faces, "test");
  const std::vector<TetShape> shapes = TetShapesOf(solid.points, solid.tets);
  PointsX3 tangled = solid.points;
  for (Eigen::Index i = mesh.vertex_count(); i < tangled.rows(); i += 3)
    tangled.row(i) = 0.9 * tangled.row(i).reverse();
  int inverted = 0;
  for (Eigen::Index t = 0; t < solid.tets.rows(); ++t)
    inverted += MapOf(shapes[t], tangled, solid.tets, t).determinant() <= 0;
  EXPECT_GT(inverted, 50);
  EXPECT_EQ(Untangle(solid, shapes, mesh.vertex_count(), tangled), 0);
  EXPECT_TRUE(SameBits(tangled.topRows(mesh.vertex_count()), mesh.points));
}

TEST(PlaceInside, InnerPointsOfAnEvenlyStretchedSolidAreStretchedAlike) {
  const Mesh mesh = MakeIcosphere(2);
  const Solid solid = Tetrahedralize(mesh.points, mesh.faces, "test");
  const Eigen::Matrix3d map = Turn(2, {1, 2, 3}) * 1.7;
  const PointsX3 placed = PlaceInside(solid, TetShapesOf(solid.points, solid.tets), mesh.faces,
                                      mesh.points * map.transpose());
  EXPECT_LT(Gap(placed, solid.points * map.transpose()), 1e-12);
}

}  // namespace keypose::interpolation::place_inside_test
