#include "cleanup/repair/intersections.h"

#include <gtest/gtest.h>

#include "cleanup/testing/damaged_meshes.h"
#include "core/surfaces/shapes.h"

namespace keypose::cleanup::intersections_test {

Mesh Moved(Mesh mesh, const Eigen::RowVector3d& by, double scale = 1) {
  mesh.points = (mesh.points * scale).rowwise() + by;
  return mesh;
}

TEST(IntersectingFaces, CountsTheFacesOfTwoCrossingBoxes) {
  int pairs = 0;
  EXPECT_TRUE(IntersectingFaces(MakeBox(1, 1, 1), &pairs).empty());
  EXPECT_EQ(pairs, 0);
  EXPECT_FALSE(IntersectingFaces(
                   Together(MakeBox(1, 1, 1), Moved(MakeBox(1, 1, 1), {0.5, 0.4, 0.3})), &pairs)
                   .empty());
  EXPECT_GT(pairs, 0);
}

}  // namespace keypose::cleanup::intersections_test
