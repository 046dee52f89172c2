#include "core/io/meshes/face_colors.h"

#include <gtest/gtest.h>

#include <limits>

namespace keypose::face_colors_test {

constexpr double kNoColor = std::numeric_limits<double>::quiet_NaN();

/// Two triangles of a square that share the corners 0 and 2, and a third apart.
Mesh Triangles() {
  Mesh mesh;
  mesh.points = PointsX3::Zero(7, 3);
  mesh.faces.resize(3, 3);
  mesh.faces << 0, 1, 2, 0, 2, 3, 4, 5, 6;
  return mesh;
}

Eigen::RowVector3i ColorOf(const Mesh& mesh, int vertex) {
  return mesh.colors.row(vertex).cast<int>();
}

TEST(FaceColors, VerticesTakeTheMeanOfTheirFaces) {
  Mesh mesh = Triangles();
  Eigen::MatrixX3d levels(3, 3);
  levels << 200, 0, 0, 0, 100, 0, 0, 0, 1;
  EXPECT_TRUE(TakeFaceColors(levels, &mesh));
  ASSERT_EQ(mesh.colors.rows(), 7);
  EXPECT_EQ(ColorOf(mesh, 0), Eigen::RowVector3i(100, 50, 0));
  EXPECT_EQ(ColorOf(mesh, 1), Eigen::RowVector3i(200, 0, 0));
  EXPECT_EQ(ColorOf(mesh, 3), Eigen::RowVector3i(0, 100, 0));
  EXPECT_EQ(ColorOf(mesh, 5), Eigen::RowVector3i(0, 0, 1)) << "a level of 1 is not white";
}

TEST(FaceColors, PartsOfOneColorLoseNothing) {
  Mesh mesh = Triangles();
  Eigen::MatrixX3d levels(3, 3);
  levels << 9, 8, 7, 9, 8, 7, 1, 1, 1;
  EXPECT_FALSE(TakeFaceColors(levels, &mesh));
  EXPECT_EQ(ColorOf(mesh, 2), Eigen::RowVector3i(9, 8, 7));
}

TEST(FaceColors, FacesWithoutAColorTakeTheirNeighbours) {
  Mesh mesh = Triangles();
  Eigen::MatrixX3d levels = Eigen::MatrixX3d::Constant(3, 3, kNoColor);
  EXPECT_FALSE(TakeFaceColors(levels, &mesh));
  EXPECT_EQ(mesh.colors.rows(), 0);
  levels.row(0) << 50, 60, 70;
  EXPECT_FALSE(TakeFaceColors(levels, &mesh));
  EXPECT_EQ(ColorOf(mesh, 3), Eigen::RowVector3i(50, 60, 70));
}

}  // namespace keypose::face_colors_test
