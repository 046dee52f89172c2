#include "core/io/meshes/some_colors.h"

#include <gtest/gtest.h>

namespace keypose::some_colors_test {

/// A strip of triangles 0 1 2, 1 2 3, ...
FacesX3 Strip(int triangles) {
  FacesX3 faces(triangles, 3);
  for (int f = 0; f < triangles; ++f) faces.row(f) << f, f + 1, f + 2;
  return faces;
}

TEST(SomeColors, VerticesWithoutOneTakeTheMeanOfTheirNeighbours) {
  const ColorsX3 colors = ColorsOfSome({0, 1}, {{200, 0, 0}, {0, 100, 0}}, Strip(3), 5);
  EXPECT_EQ(colors.row(0).cast<int>(), Eigen::RowVector3i(200, 0, 0));
  EXPECT_EQ(colors.row(1).cast<int>(), Eigen::RowVector3i(0, 100, 0));
  // Vertex 2 shares one face with vertex 0, two with vertex 1.
  EXPECT_EQ(colors.row(2).cast<int>(), Eigen::RowVector3i(67, 67, 0));
  EXPECT_EQ(colors.row(3).cast<int>(), Eigen::RowVector3i(0, 100, 0));
  EXPECT_EQ(colors.row(4).cast<int>(), Eigen::RowVector3i(33, 83, 0));
}

TEST(SomeColors, FractionsAndLevels) {
  EXPECT_EQ(ColorsOfSome({0}, {{1, 0.5, 0}}, Strip(1), 3).row(0).cast<int>(),
            Eigen::RowVector3i(255, 128, 0));
  EXPECT_EQ(ColorsOfSome({0}, {{2, 1, 0}}, Strip(1), 3).row(0).cast<int>(),
            Eigen::RowVector3i(2, 1, 0));
}

TEST(SomeColors, APartWithoutAnyTakesTheMeanOfAll) {
  const ColorsX3 colors =
      ColorsOfSome({0, 1, 2}, {{90, 0, 0}, {0, 90, 0}, {0, 0, 90}}, Strip(1), 4);
  EXPECT_EQ(colors.row(3).cast<int>(), Eigen::RowVector3i(30, 30, 30));
  EXPECT_EQ(ColorsOfSome({}, {}, Strip(1), 3).rows(), 0);
}

}  // namespace keypose::some_colors_test
