#include "deform/levels/landmark_coordinates.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numeric>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::landmark_coordinates_test {

/// A tube that is thicker at one end and bulges at one side, so that no two places are alike.
Mesh Lopsided() {
  Mesh mesh = MakeCylinder(0.3, 2, 24, 40);
  for (Eigen::Index i = 0; i < mesh.points.rows(); ++i) {
    const double z = mesh.points(i, 2), grow = 1 + 0.3 * z + 0.2 * std::sin(3 * z);
    mesh.points(i, 0) = mesh.points(i, 0) * grow + 0.1 * z * z;
    mesh.points(i, 1) *= grow;
  }
  return mesh;
}

TEST(LandmarkCoordinates, AMeshMatchesToItself) {
  const Mesh mesh = Lopsided();
  const std::vector<int> marks = {3, 170, 333, 512, 790, 960};
  const LandmarkCoordinates coordinates(mesh.points, mesh.faces, marks, mesh.points, mesh.faces,
                                        marks);
  std::vector<int> vertices(mesh.vertex_count());
  std::iota(vertices.begin(), vertices.end(), 0);
  const auto matches = coordinates.MatchVertices(vertices);
  ASSERT_EQ(matches.size(), vertices.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    EXPECT_EQ(matches[v].vertex, static_cast<int>(v));
    EXPECT_LT(matches[v].mismatch, 0.01);
  }
}

TEST(LandmarkCoordinates, BendingAndSizeDoNotMatter) {
  const Mesh source = Lopsided();
  Mesh target = source;
  for (Eigen::Index i = 0; i < target.points.rows(); ++i) {
    const double a = source.points(i, 2) * 0.6, r = 1 / 0.6 - source.points(i, 1);
    target.points.row(i) << source.points(i, 0), 1 / 0.6 - r * std::cos(a), r * std::sin(a);
  }
  const std::vector<int> marks = {3, 170, 333, 512, 790, 960};
  const LandmarkCoordinates coordinates(source.points, source.faces, marks, target.points,
                                        target.faces, marks);
  std::vector<int> vertices(source.vertex_count());
  std::iota(vertices.begin(), vertices.end(), 0);
  const auto matches = coordinates.MatchVertices(vertices);
  double sum = 0;
  for (std::size_t v = 0; v < vertices.size(); ++v)
    sum += (source.points.row(matches[v].vertex) - source.points.row(v)).norm();
  EXPECT_LT(sum / static_cast<double>(vertices.size()) / BoundingDiagonal(source.points), 0.04);
}

}  // namespace keypose::landmark_coordinates_test
