#include "core/io/project/transforms_write.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/transforms_io.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::transforms_write_test {

/// A camera that looks along x from (-5, 0, 2), upright.
View AlongX(const std::string& name) {
  Eigen::Matrix3d camera_from_world;
  camera_from_world << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  View view;
  view.name = name;
  view.camera = {400, 300, 510, 500, 190, 155, 0.1, -0.02, 1e-3, 2e-3};
  view.camera_from_world.rotation = Eigen::Quaterniond(camera_from_world);
  view.camera_from_world.translation = -(camera_from_world * Eigen::Vector3d(-5, 0, 2));
  return view;
}

TEST(TransformsText, AxesAreThoseOfOpenGl) {
  const auto root =
      nlohmann::json::parse(TransformsText({AlongX("a.jpg")}, {{"images/a.jpg", ""}}, ""));
  const double matrix[4][4] = {{0, 0, -1, -5}, {-1, 0, 0, 0}, {0, 1, 0, 2}, {0, 0, 0, 1}};
  for (std::size_t r = 0; r < 4; ++r)
    for (std::size_t c = 0; c < 4; ++c)
      EXPECT_NEAR(root["frames"][0]["transform_matrix"][r][c].get<double>(), matrix[r][c], 1e-15);
  EXPECT_FALSE(root["frames"][0].contains("mask_path"));
  EXPECT_FALSE(root.contains("ply_file_path"));
  EXPECT_EQ(root["fl_x"], 510);
}

TEST(TransformsText, ComesBackBitByBitButForRounding) {
  const TestingFolder folder;
  View other = AlongX("b.jpg");
  other.camera.fx = 700.0 / 3;
  const auto read = ReadTransforms(
      folder.Put("transforms.json",
                 TransformsText({AlongX("a.jpg"), other},
                                {{"i/a.jpg", "m/a.png"}, {"i/b.jpg", "m/b.png"}}, "points.ply")));
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[1].name, "b.jpg");
  EXPECT_EQ(read[0].lens.fx, 510);
  EXPECT_EQ(read[1].lens.fx, 700.0 / 3);
  EXPECT_EQ(read[1].lens.p2, 2e-3);
  const Eigen::Vector3d x(1, 0.3, 1.5);
  EXPECT_LT((*read[1].lens.Project(read[1].camera_from_world * x) - other.Project(x)).norm(), 1e-9);
}

TEST(TransformsText, NamesThatJsonCannotHoldAreRefused) {
  EXPECT_THROW(TransformsText({AlongX("a\xff.jpg")}, {{"images/a\xff.jpg", ""}}, ""), InputError);
}

TEST(SparsePlyText, PointsAndColoursComeBack) {
  const TestingFolder folder;
  SparsePoint point;
  point.position = {0.1, -2, 3};
  point.color << 10, 200, 255;
  const PointCloud cloud = ReadPointCloud(folder.Put("p.ply", SparsePlyText({point, point})));
  ASSERT_EQ(cloud.points.rows(), 2);
  EXPECT_LT((cloud.points.row(1).transpose() - point.position).norm(), 1e-8);
  ASSERT_EQ(cloud.colors.rows(), 2);
  EXPECT_EQ(cloud.colors(1, 1), 200);
}

}  // namespace keypose::transforms_write_test
